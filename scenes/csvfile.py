# SPDX-License-Identifier: Apache-2.0
"""The CSV beside a page."""
import csv
import os


def write(path, columns, rows):
    """Rows are sequences, or dicts by column: what they lack is empty, what no column names is left out. A whole file
    or none: it is renamed into place."""
    with open(path + ".part", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        for row in rows:
            writer.writerow([row.get(column, "") for column in columns] if isinstance(row, dict) else row)
    os.replace(path + ".part", path)
