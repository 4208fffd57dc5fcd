"""Reads or builds an MJCF in a process of its own, so that what exhausts or crashes MuJoCo ends no other.

`mjcf_limits` runs this file; it prints the files that MuJoCo read, and what it says if it cannot, as JSON.
"""

import json
import resource
import sys
from pathlib import Path

import mujoco

path, what, most_bytes = sys.argv[1:]
in_use = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[5]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_DATA, (in_use + int(most_bytes),) * 2)
files, refusal = [], None
try:
    if what == "read":
        files = mujoco.mju_getXMLDependencies(path)
    else:
        mujoco.MjModel.from_xml_path(path)
except (ValueError, mujoco.FatalError) as error:
    refusal = str(error)
print(json.dumps([files, refusal]))
