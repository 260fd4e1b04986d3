# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender may crash on a damaged file: with the work in a child process the user gets a sentence all the same."""
import ctypes
import os
import shlex
import signal
import sys

PR_SET_PDEATHSIG = 1


def enter(program):
    """Returns in the child; the parent ends as the child does, but with status 3 where that crashes. To be called
    before bpy is loaded: its threads would not survive the fork. Within Blender, and on other systems, it does nothing.
    """
    if "bpy" in sys.modules or sys.platform != "linux":
        return
    parent, passed_on = os.getpid(), (signal.SIGINT, signal.SIGTERM)
    signal.pthread_sigmask(signal.SIG_BLOCK, passed_on)  # until there is a handler
    child = os.fork()
    if child == 0:
        os.setpgid(0, 0)  # Ctrl-C reaches the parent alone, which passes it on
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:
            os._exit(1)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, passed_on)
        return
    for number in passed_on:
        signal.signal(number, lambda number, frame: os.kill(child, number))
    signal.pthread_sigmask(signal.SIG_UNBLOCK, passed_on)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if -status in passed_on:
        signal.signal(-status, signal.SIG_DFL)
        os.kill(os.getpid(), -status)
    if status < 0:
        print(f"{program}: Blender crashed ({signal.strsignal(-status).lower()}) given {shlex.join(sys.argv[1:])}: "
              "the file may be damaged", file=sys.stderr)
        status = 3
    sys.exit(status)
