"""A reader of binary glTF that shares nothing with the writer: chunks, accessors, and the node tree at a time."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np

COMPONENTS = {5126: np.dtype("<f4"), 5125: np.dtype("<u4"), 5121: np.dtype("<u1"), 5123: np.dtype("<u2")}
SIZES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
IDLE = {"translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}


class GlbFile:
    """A file that is read. Quaternions are x, y, z, w, as in glTF."""

    def __init__(self, data: bytes) -> None:
        magic, number, length, text, kind = struct.unpack("<4sIII4s", data[:20])
        assert (magic, number, length, kind) == (b"glTF", 2, len(data), b"JSON")
        self.tree: dict[str, Any] = json.loads(data[20 : 20 + text])
        size, kind = struct.unpack("<I4s", data[20 + text : 28 + text])
        assert kind == b"BIN\0" and text % 4 == size % 4 == 0 and 28 + text + size == length
        self.binary = data[28 + text :]
        self.nodes = {node["name"]: node for node in self.tree["nodes"]}
        assert len(self.nodes) == len(self.tree["nodes"])
        children = [(child, i) for i, node in enumerate(self.tree["nodes"]) for child in node.get("children", [])]
        self.parents = dict(children)
        assert len(self.parents) == len(children)

    def array(self, index: int) -> np.ndarray:
        """Return an accessor's (N, n) values."""
        accessor = self.tree["accessors"][index]
        view = self.tree["bufferViews"][accessor["bufferView"]]
        kind, width = COMPONENTS[accessor["componentType"]], SIZES[accessor["type"]]
        start = view["byteOffset"] + accessor.get("byteOffset", 0)
        assert start % 4 == 0
        size = accessor["count"] * width * kind.itemsize
        assert accessor.get("byteOffset", 0) + size <= view["byteLength"]
        assert start + size <= len(self.binary)
        return np.frombuffer(self.binary, kind, accessor["count"] * width, start).reshape(-1, width)

    def channels(self, animation: str) -> dict[tuple[str, str], tuple[np.ndarray, np.ndarray, str]]:
        """Return times, values and interpolation by (node, path)."""
        (found,) = (one for one in self.tree["animations"] if one["name"] == animation)
        result = {}
        for channel in found["channels"]:
            sampler = found["samplers"][channel["sampler"]]
            node = self.tree["nodes"][channel["target"]["node"]]["name"]
            times, values = self.array(sampler["input"])[:, 0], self.array(sampler["output"])
            result[node, channel["target"]["path"]] = times, values, sampler["interpolation"]
        assert len(result) == len(found["channels"])
        return result

    def poses(self, animation: str, times: np.ndarray) -> dict[str, np.ndarray]:
        """Return the (T, 4, 4) pose of every node in the file's frame."""
        channels = self.channels(animation)
        found: dict[str, np.ndarray] = {}

        def pose(index: int) -> np.ndarray:
            node = self.tree["nodes"][index]
            if node["name"] not in found:
                local = self._local(node, channels, times)
                parent = self.parents.get(index)
                found[node["name"]] = local if parent is None else pose(parent) @ local
            return found[node["name"]]

        for index in range(len(self.tree["nodes"])):
            pose(index)
        return found

    def _local(self, node: dict[str, Any], channels: Any, times: np.ndarray) -> np.ndarray:
        if "matrix" in node:
            return np.tile(np.array(node["matrix"]).reshape(4, 4).T, (len(times), 1, 1))
        parts = {}
        for path, idle in IDLE.items():
            if (node["name"], path) in channels:
                parts[path] = interpolated(path, *channels[node["name"], path], times)
            else:
                parts[path] = np.tile(np.array(node.get(path, idle), dtype=float), (len(times), 1))
        matrix = np.tile(np.eye(4), (len(times), 1, 1))
        matrix[:, :3, :3] = turned(parts["rotation"]) * parts["scale"][:, None]
        matrix[:, :3, 3] = parts["translation"]
        return matrix


def interpolated(path: str, keys: np.ndarray, values: np.ndarray, how: str, times: np.ndarray) -> np.ndarray:
    """Return the (T, n) values of a channel, as the specification's appendix C says."""
    keys, values = keys.astype(float), values.astype(float)
    after = np.clip(np.searchsorted(keys, times, side="right"), 1, max(1, len(keys) - 1))
    if how == "STEP":
        return values[np.searchsorted(keys, times, side="right").clip(1) - 1]
    before = after - 1
    share = np.clip((times - keys[before]) / (keys[after] - keys[before]), 0, 1)[:, None]
    one, two = values[before], values[after]
    if path != "rotation":
        return one + share * (two - one)
    cosine = np.sum(one * two, axis=1, keepdims=True)
    angle = np.arccos(np.clip(np.abs(cosine), 0, 1))
    small = angle < 1e-7
    sine = np.where(small, 1.0, np.sin(angle))
    weight = np.where(small, 1 - share, np.sin((1 - share) * angle) / sine)
    other = np.where(small, share, np.sin(share * angle) / sine) * np.where(cosine < 0, -1, 1)
    return weight * one + other * two


def turned(quaternions: np.ndarray) -> np.ndarray:
    """Return (T, 3, 3) matrices."""
    x, y, z, w = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)
