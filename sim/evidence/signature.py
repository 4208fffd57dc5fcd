"""Signatures of logs: Ed25519 (RFC 8032) over all of a file but its last 64 bytes, which are the signature.

A ZIP archive may end with a comment. The signature is this comment, so that a signed log is read like any other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

from prefplan.claims import Check
from sim.errors import LogError

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey

T = TypeVar("T")

SIGNATURE_BYTES = 64
"""Length of an Ed25519 signature."""

COMMENT_LENGTH_BYTES = 2
"""Length of the last field of a ZIP archive without a comment: the length of its comment, little-endian."""


def sign(contents: bytes, key: Ed25519PrivateKey) -> bytes:
    """Return the contents of a log's file, as `encode` returns them, with a signature."""
    length = SIGNATURE_BYTES.to_bytes(COMMENT_LENGTH_BYTES, "little")
    signed = contents[:-COMMENT_LENGTH_BYTES] + length
    return signed + key.sign(signed)


def check_signature(contents: bytes, key: Ed25519PublicKey) -> Check:
    """Check that the contents of a log's file are what the owner of a key signed."""
    from cryptography.exceptions import InvalidSignature

    if len(contents) < SIGNATURE_BYTES or contents[-SIGNATURE_BYTES - COMMENT_LENGTH_BYTES] != SIGNATURE_BYTES:
        return Check("signature", False, "the file is not signed")
    signed, signature = contents[:-SIGNATURE_BYTES], contents[-SIGNATURE_BYTES:]
    try:
        key.verify(signature, signed)
    except InvalidSignature:
        return Check("signature", False, "the file is not what the owner of the key signed")
    return Check("signature", True, f"{len(contents)} bytes, as the owner of the key signed them")


def read_private_key(path: Path) -> Ed25519PrivateKey:
    """Read a private key, PEM or OpenSSH, without a passphrase.

    Raises:
        LogError: the file cannot be read or holds no such key, or `cryptography` is not installed.
    """
    serialization, ed25519 = _cryptography()
    loaders = (serialization.load_pem_private_key, serialization.load_ssh_private_key)
    return _read(path, "private", [partial(load, password=None) for load in loaders], ed25519.Ed25519PrivateKey)


def read_public_key(path: Path) -> Ed25519PublicKey:
    """Read a public key, PEM or OpenSSH.

    Raises:
        LogError: the file cannot be read or holds no such key, or `cryptography` is not installed.
    """
    serialization, ed25519 = _cryptography()
    loaders = (serialization.load_pem_public_key, serialization.load_ssh_public_key)
    return _read(path, "public", loaders, ed25519.Ed25519PublicKey)


def _cryptography() -> tuple[ModuleType, ModuleType]:
    try:
        from cryptography.hazmat.primitives import serialization
        from cryptography.hazmat.primitives.asymmetric import ed25519
    except ImportError:
        raise LogError("--key: cryptography is not installed; install it: pip install cryptography") from None
    return serialization, ed25519


def _read(path: Path, which: str, loaders: Iterable[Callable[[bytes], Any]], kind: type[T]) -> T:
    from cryptography.exceptions import UnsupportedAlgorithm

    try:
        contents = path.read_bytes()
    except OSError as error:
        raise LogError(f"{path}: {str(error.strerror).lower()}") from None
    for load in loaders:
        with suppress(ValueError, TypeError, UnsupportedAlgorithm):
            key = load(contents)
            if isinstance(key, kind):
                return key
    raise LogError(f"{path}: not a {which} Ed25519 key (PEM or OpenSSH, without a passphrase)")
