# SPDX-License-Identifier: Apache-2.0
"""Steps done and to come, with the time left by what has been done."""
import time


class Progress:
    def __init__(self, steps, expected):
        """expected: seconds of all steps on some machine; only their ratios count once a step is done."""
        self.total, self.expected = steps, expected
        self.start, self.step, self.behind = time.monotonic(), 0, 0

    def passed(self):
        return time.monotonic() - self.start

    def begin(self, text, expected):
        self.step += 1
        passed, ahead = self.passed(), self.expected - self.behind
        left = ahead * (passed / self.behind if self.behind else 1)
        print(f"[{self.step}/{self.total}] {passed:.0f} s, about {left / 60:.0f} min left  {text}", flush=True)
        self.behind += expected
