# SPDX-License-Identifier: Apache-2.0
"""What was measured or rendered once is kept under the hash of all that it depends on, so that a run that was stopped
goes on where it was, and what has changed is made anew."""
import functools
import hashlib
import json
import os


@functools.cache
def digest(path):
    """Of a file's bytes, or of all files in a folder; it must not change while the program runs."""
    paths = [path]
    if os.path.isdir(path):
        paths = [os.path.join(place, name) for place, _, names in sorted(os.walk(path)) for name in sorted(names)]
    total = hashlib.sha256()
    for each in paths:
        with open(each, "rb") as file:
            total.update(hashlib.file_digest(file, "sha256").digest())
    return total.hexdigest()


class Kept:
    def __init__(self, folder):
        self.folder = folder
        os.makedirs(folder, exist_ok=True)

    def path(self, key, ending):
        """Of a file for `key`, which is anything that json can write."""
        name = hashlib.sha256(json.dumps(key, sort_keys=True).encode()).hexdigest()[:24]
        return os.path.join(self.folder, name + ending)

    def get(self, key):
        """What put() kept, or None."""
        try:
            with open(self.path(key, ".json"), encoding="utf-8") as file:
                return json.load(file)
        except FileNotFoundError:
            return None

    def put(self, key, value):
        """Written last of all that belongs to key: it marks the rest as whole."""
        path = self.path(key, ".json")
        with open(path + ".part", "w", encoding="utf-8") as file:
            json.dump(value, file)
        os.replace(path + ".part", path)
