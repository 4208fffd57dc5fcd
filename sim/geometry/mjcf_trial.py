"""Builds an MJCF in a separate process: a file that exhausts memory or crashes MuJoCo ends no other process.

`mjcf_limits` runs this file; it prints in JSON the `files` that MuJoCo reads, and then the `refusal`, which is empty if
the model was built.
"""

import json
import resource
import sys
from pathlib import Path

import mujoco

path, most_bytes = sys.argv[1:]
in_use = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[5]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_DATA, (in_use + int(most_bytes),) * 2)
refusal = ""
try:
    print(json.dumps({"files": mujoco.mju_getXMLDependencies(path)}), flush=True)
    mujoco.MjModel.from_xml_path(path)
except (ValueError, mujoco.FatalError) as error:
    refusal = str(error)
print(json.dumps({"refusal": refusal}))
