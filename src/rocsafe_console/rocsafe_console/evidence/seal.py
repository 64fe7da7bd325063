# SPDX-License-Identifier: Apache-2.0
"""The seal of a run: hashes of all its files and of its log, signed with Ed25519.

``seal-0001.json`` in the folder of the run has the SHA-256 and size of each file, the state of the
evidence log, who sealed it and when, the seal before, and if there is a key the signature and the
public key. Raw evidence never changes after its first seal. Products that are made again
(`PRODUCTS`) may: they become a new seal beside the old ones.
"""

import base64
import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey

from rocsafe_geo.evidence.evidence_log import (
    LOG_NAME,
    EvidenceError,
    faults_of,
    line_of,
    segments_of,
    whole_lines,
)
from rocsafe_geo.storage.durable import write_whole
from rocsafe_geo.storage.secret_file import SecretFileError, read_secret

FORMAT = 'rocsafe-seal-1'
# Files that `rocsafe report` and `rocsafe map` make again from the raw evidence.
PRODUCTS = ('report.html', 'summary.json', 'readings.csv', 'map/', 'mosaic')
_PIECE_BYTES = 2**20
_KEYS = frozenset({'format', 'run', 'time_s', 'by', 'version', 'before', 'log', 'files'})


def make_key(path: Path) -> str:
    """Make a new signing key in a file that only its owner can read; return its public key.

    Raises
    ------
    EvidenceError
        If the file is there already, or cannot be written.
    """
    key = Ed25519PrivateKey.generate()
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        with path.open('xb') as file:
            path.chmod(0o600)
            file.write(base64.b64encode(key.private_bytes_raw()) + b'\n')
    except OSError as error:
        raise EvidenceError(f'{path}: {error.strerror}') from error
    return _public_text(key)


def read_key(path: Path) -> Ed25519PrivateKey:
    """Return the signing key in a file; raises `EvidenceError` naming the file."""
    try:
        return Ed25519PrivateKey.from_private_bytes(base64.b64decode(read_secret(path)))
    except SecretFileError as error:
        raise EvidenceError(str(error)) from error
    except ValueError as error:
        raise EvidenceError(f'{path} holds no signing key: make one by seal --make-key') from error


def public_key_of(path: Path) -> str:
    """Return the public key of the signing key in a file, as text; raises `EvidenceError`."""
    return _public_text(read_key(path))


def seal_run(
    run: Path, time_s: float, by: str, version: str, key: Ed25519PrivateKey | None = None
) -> Path:
    """Seal a run and return the file of the seal.

    Parameters
    ----------
    time_s
        By the clock on the wall, seconds since 1970.
    by, version
        Who seals it, and with which version of the code.
    key
        Signs the seal; None: it is not signed.

    Raises
    ------
    EvidenceError
        If raw evidence differs from an earlier seal, the log is no whole chain, or the seal
        before is signed with another key.
    """
    before = seals_of(run)
    files = {str(path.relative_to(run)): _fingerprint(path) for path in _files(run)}
    if before:
        _require_same_signer(before[-1], _public_text(key) if key else '')
        contents = [_content(path) for path in before]
        faults = list(_chain_faults(before, contents))
        faults += [text for kind, text in _differences(contents[-1], files) if kind == 'raw']
        faults += _lost_lines(run, contents)
        if faults:
            raise EvidenceError('; '.join(faults))
    content: dict[str, Any] = {
        'format': FORMAT,
        'run': run.name,
        'time_s': time_s,
        'by': by,
        'version': version,
        'before': hashlib.sha256(before[-1].read_bytes()).hexdigest() if before else None,
        'log': _log_state(run),
        'files': files,
    }
    signed: dict[str, Any] = {'seal': content}
    if key is not None:
        signed['public_key'] = _public_text(key)
        signed['signature'] = base64.b64encode(key.sign(line_of(content))).decode()
    path = run / f'seal-{len(before) + 1:04d}.json'
    write_whole(path, _written(signed))
    return path


def seals_of(run: Path) -> list[Path]:
    """Return the seals of a run, the first one first."""
    return sorted(run.glob('seal-[0-9][0-9][0-9][0-9].json'))


def verify_run(run: Path, public_key: str = '') -> list[str]:
    """Return what is wrong with a run, one line each; none: every byte is as it was sealed.

    Parameters
    ----------
    public_key
        That must have signed it; empty: any, named by the seal.
    """
    seals = seals_of(run)
    if not seals:
        return [f'{run} is not sealed']
    try:
        contents = [_content(path, public_key) for path in seals]
        faults = list(_chain_faults(seals, contents))
        faults += faults_of(run / LOG_NAME) or _lost_lines(run, contents)
    except EvidenceError as error:
        return [str(error)]
    files = {str(path.relative_to(run)): _fingerprint(path) for path in _files(run)}
    return faults + [text for _, text in _differences(contents[-1], files)]


def notes_of(run: Path) -> list[str]:
    """Return what a reader must know of a run in which `verify_run` finds nothing wrong."""
    seal = json.loads(seals_of(run)[-1].read_bytes())['seal']
    newest = segments_of(run / LOG_NAME)[-1:]
    added = len(whole_lines(newest[0])[0]) - seal['log']['lines'] if newest else 0
    notes = [f'{LOG_NAME}: the last {added} lines are in no seal'] if added else []
    if seal['run'] != run.name:
        notes.append(f'it was sealed as the run {seal["run"]}')
    return notes


def signer_of(seal: Path) -> str:
    """Return the public key that signed a seal, empty if none did."""
    return str(json.loads(seal.read_bytes()).get('public_key', ''))


def _chain_faults(seals: list[Path], contents: list[dict[str, Any]]) -> Iterator[str]:
    """Yield what is wrong between a seal and the one before it."""
    for number, (path, content) in enumerate(zip(seals, contents, strict=True)):
        before = seals[number - 1] if number else None
        digest = hashlib.sha256(before.read_bytes()).hexdigest() if before else None
        if content['before'] != digest:
            yield f'{path.name}: does not follow the seal before'
        if before is None:
            continue
        if signer_of(before) not in ('', signer_of(path)):
            yield f'{path.name}: is not signed with the key of {before.name}'
        for kind, text in _differences(contents[number - 1], content['files']):
            if kind == 'raw':
                yield f'{path.name}: {text} since {before.name}'


def _log_state(run: Path) -> dict[str, Any]:
    """Return lines and last hash of the newest segment: its first line has the hash of the others.

    Raises
    ------
    EvidenceError
        If it is damaged.
    """
    segments = segments_of(run / LOG_NAME)
    entries, fault = whole_lines(segments[-1]) if segments else ([], '')
    if fault:
        raise EvidenceError(fault)
    name = {'name': segments[-1].name} if segments[1:] else {}
    return {'lines': len(entries), 'last': entries[-1]['hash'] if entries else None, **name}


def _lost_lines(run: Path, contents: list[dict[str, Any]]) -> list[str]:
    """Return what is wrong with the lines that were sealed; others may have been added since."""
    for sealed in (content['log'] for content in contents):
        path = run / sealed.get('name', LOG_NAME)
        entries = whole_lines(path)[0] if path.is_file() else []
        if len(entries) < sealed['lines']:
            return [f'{path.name}: has {len(entries)} lines, {sealed["lines"]} were sealed']
        if sealed['lines'] and entries[sealed['lines'] - 1]['hash'] != sealed['last']:
            return [f'{path.name}: is not the log that was sealed']
    return []


def _require_same_signer(before: Path, signer: str) -> None:
    """Refuse a seal that somebody else signs than the one before; raises `EvidenceError`."""
    known = signer_of(before)
    if known not in ('', signer):
        raise EvidenceError(f'{before.name} is signed with {known}: sign with this key, too')


def _written(signed: Mapping[str, Any]) -> bytes:
    """Return the one form in which a seal is written: a byte more or less is a change."""
    return json.dumps(signed, sort_keys=True, indent=1).encode() + b'\n'


def _content(path: Path, public_key: str = '') -> dict[str, Any]:
    """Return the content of a seal whose signature is right; raises `EvidenceError`."""
    try:
        data = path.read_bytes()
        signed = json.loads(data)
        content: dict[str, Any] = signed['seal']
        if content['format'] != FORMAT:
            raise EvidenceError(f'{path.name}: its format is {content["format"]!r}')
        if _written(signed) != data or set(content) != _KEYS:
            raise EvidenceError(f'{path.name}: has been changed')
        _require_whole(content)
        signer = signed.get('public_key', '')
        if public_key and signer != public_key:
            raise EvidenceError(f'{path.name}: is not signed with the key {public_key}')
        if signer:
            key = Ed25519PublicKey.from_public_bytes(_bytes_of(signer))
            key.verify(_bytes_of(signed['signature']), line_of(content))
        elif 'signature' in signed:
            raise EvidenceError(f'{path.name}: has a signature and no public key')
    except InvalidSignature as error:
        raise EvidenceError(f'{path.name}: the signature is not right') from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise EvidenceError(f'{path.name}: is no seal') from error
    return content


def _require_whole(content: Mapping[str, Any]) -> None:
    """Refuse a seal without what verification reads; raises `KeyError` or `TypeError`."""
    if not isinstance(content['files'], dict) or not isinstance(content['log']['lines'], int):
        raise TypeError('files must be a mapping, lines a number')
    if content['log']['lines']:
        content['log']['last'].encode()
    if '/' in content['log'].get('name', LOG_NAME):
        raise TypeError('the name of a log must be that of a file')


def _bytes_of(text: str) -> bytes:
    """Return the bytes of a text in base 64 of which no letter can be changed."""
    data = base64.b64decode(text, validate=True)
    if base64.b64encode(data).decode() != text:
        raise ValueError('not as it was written')
    return data


def _differences(
    content: dict[str, Any], files: dict[str, dict[str, Any]]
) -> Iterator[tuple[str, str]]:
    """Yield kind (raw or product) and text of each file that is not as it was sealed."""
    sealed = content['files']
    for name in sorted(sealed.keys() | files.keys()):
        kind = 'product' if name.startswith(PRODUCTS) else 'raw'
        if name not in files:
            yield kind, f'{name}: is gone'
        elif name not in sealed:
            yield 'added', f'{name}: is not in the seal'
        elif files[name] != sealed[name]:
            yield kind, f'{name}: has been changed'


def _files(run: Path) -> Iterator[Path]:
    """Yield what a seal covers: every file and link but the log, which grows, and seals."""
    others = {*seals_of(run), run / LOG_NAME, *segments_of(run / LOG_NAME)}
    for path in sorted(run.rglob('*')):
        if (path.is_file() or path.is_symlink()) and path not in others:
            yield path


def _fingerprint(path: Path) -> dict[str, Any]:
    if path.is_symlink():
        return {'link': str(path.readlink())}
    digest, size = hashlib.sha256(), 0
    with path.open('rb') as file:
        while piece := file.read(_PIECE_BYTES):
            digest.update(piece)
            size += len(piece)
    return {'sha256': digest.hexdigest(), 'bytes': size}


def _public_text(key: Ed25519PrivateKey) -> str:
    return base64.b64encode(key.public_key().public_bytes_raw()).decode()
