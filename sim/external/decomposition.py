"""Decomposes a mesh in a separate process, which limits of time and Ctrl-C can end.

`meshes` runs this file: it reads the mesh as NumPy's archive and prints the vertices of its convex parts as another.
"""

import io
import json
import sys

import coacd
import numpy as np

with np.load(io.BytesIO(sys.stdin.buffer.read())) as given:
    mesh = coacd.Mesh(given["vertices"], given["faces"])
coacd.set_log_level("off")
parts = coacd.run_coacd(mesh, **json.loads(sys.argv[1]))
np.savez(sys.stdout.buffer, *(np.asarray(vertices, dtype=np.float64) for vertices, _ in parts))
