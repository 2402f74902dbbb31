"""Functions that damage bytes, JSON trees, tables and arrays, with a given generator."""

import json
from collections.abc import Callable
from random import Random
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Texts that have broken programs.
TEXTS = (
    "", " ", "\x00", "\x1b[2J\x1b]0;owned\x07", "\r\rfirstcontact: done", "a\nb", "\u202egnp.exe",
    "\ud800", "$\\frac{$", "$x$ & {} %s", "../../etc/passwd", "/", "." * 300, "x" * 70_000,
    "é" * 150, "🖐" * 100, "<script>alert(1)</script>", "=1+1", "nan", "-inf", "1e999", "9" * 400,
    "0x10", "1_000", "１２", "true", "None",
)  # fmt: skip
#: Numbers at the edges of types and beyond them.
NUMBERS = (
    0, -1, 1, 2, 255, 65_535, 65_536, 2**31 - 1, 2**31, -(2**31) - 1, 2**32, 2**53 + 1, 2**63 - 1,
    2**63, 2**64, -(2**63) - 1, 10**18, 10**30, 0.5, -0.0, 1e-320, 1e-30, 1e-9, 1e9, 1e30, 1.7e308,
    -1.7e308,
)  # fmt: skip
#: What JSON text may hold and Python's json does not write by itself.
TOKENS = ("NaN", "Infinity", "-Infinity", "1e999", "9" * 400, "1.0e-400", "-", "01", "[" * 3000)
#: A tree whose text is longer is not changed any more, characters.
LARGE = 200_000
_MARK = "@token {}@"


def text(rng: Random) -> str:
    """Return a hostile text."""
    return rng.choice(TEXTS)


def value(rng: Random) -> Any:
    """Return a JSON value of any kind."""
    kind = rng.randrange(8)
    if kind == 0:
        return text(rng)
    if kind in (1, 2):
        return rng.choice(NUMBERS)
    if kind == 3:
        return _MARK.format(rng.randrange(len(TOKENS)))
    if kind == 4:
        return rng.choice((None, True, False))
    if kind == 5:
        return rng.choice(([], {}, [None], [[]], {"": 1}, [1, 2, 3], {"a": {"b": []}}))
    if kind == 6:
        deep: Any = 0
        for _ in range(rng.choice((5, 100, 300))):
            deep = [deep]
        return deep
    return [rng.choice(NUMBERS)] * rng.choice((1, 7, 1000, 20_000))


def tree(rng: Random, root: Any, times: int | None = None) -> bytes:
    """Return a JSON tree with a few changes."""
    root = json.loads(json.dumps(root))
    for _ in range(times or rng.choice((1, 1, 1, 2, 3))):
        if len(json.dumps(root)) < LARGE:
            root = _changed(rng, root)
    written = json.dumps(root, ensure_ascii=rng.random() < 0.8).encode(errors="surrogatepass")
    for i, token in enumerate(TOKENS):
        written = written.replace(b'"' + _MARK.format(i).encode() + b'"', token.encode())
    if rng.random() < 0.03:
        written = raw(rng, written)
    return written


def _places(root: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    computed = [path] if path else []
    if isinstance(root, dict):
        for key in root:
            computed += _places(root[key], (*path, key))
    elif isinstance(root, list):
        for i in range(min(len(root), 20)):
            computed += _places(root[i], (*path, i))
    return computed


def _changed(rng: Random, root: Any) -> Any:
    places = _places(root)
    if not places or rng.random() < 0.01:
        return value(rng)
    *above, key = rng.choice(places)
    holder = root
    for step in above:
        holder = holder[step]
    old = holder[key]
    kind = rng.randrange(7)
    if kind <= 2:
        holder[key] = value(rng)
    elif kind == 3:
        holder[key] = _near(rng, old)
    elif kind == 4:
        del holder[key]
    elif kind == 5 and isinstance(holder, dict):
        holder[rng.choice((text(rng), "unknown", str(key) + " "))] = (
            holder.pop(key) if rng.random() < 0.5 else old
        )
    elif isinstance(holder, list):
        holder[key:key] = [old] * min(rng.choice((1, 2, 50, 2000)), LARGE // len(json.dumps(old)))
    else:  # what belongs somewhere else
        other = root
        for step in rng.choice(places):
            other = other[step] if not isinstance(other, int | str | float | None) else other
        holder[key] = json.loads(json.dumps(other))
    return root


def _near(rng: Random, old: Any) -> Any:
    """Return a random value of the same kind."""
    if isinstance(old, bool):
        return not old
    if isinstance(old, int) and abs(old) < 2**64:
        return rng.choice((old + 1, old - 1, -old, old * 2, old * 1000, float(old), str(old)))
    if isinstance(old, float):
        return rng.choice((old * (1 + 1e-9), -old, old * 1e6, old * 1e-6, old * 1e200, old // 1))
    if isinstance(old, str):
        return rng.choice((old.upper(), old + text(rng), old[: len(old) // 2], old[:70] * 1000))
    if isinstance(old, list):
        return rng.choice((old[:-1], old[::-1], old * 2, [*old, None], {"0": old}))
    return [old]


def raw(rng: Random, data: bytes) -> bytes:
    """Return bytes with flips, cuts, insertions and copied pieces."""
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 4, 16))):
        n = len(out)
        at = rng.randrange(n) if n else 0
        long = rng.choice((1, 2, 4, 8, 64, 4096))
        kind = rng.randrange(9)
        if kind == 0 and n:
            out[at] ^= 1 << rng.randrange(8)
        elif kind == 1 and n:
            out[at] = rng.randrange(256)
        elif kind == 2:
            del out[at:]
        elif kind == 3:
            del out[at : at + long]
        elif kind == 4:
            out[at:at] = rng.randbytes(long)
        elif kind == 5:
            source = rng.randrange(n) if n else 0
            out[at : at + long] = out[source : source + long]
        elif kind == 6:
            out[at : at + long] = rng.choice((b"\0", b"\xff")) * long
        elif kind == 7:
            size = rng.choice((1, 2, 4, 8))
            number = rng.choice((0, 1, 2**7, 2**15 - 1, 2**31, 2**32 - 1, 2**63, 2**64 - 1))
            order = rng.choice(("little", "big"))
            out[at : at + size] = (number % (1 << 8 * size)).to_bytes(size, order)  # type: ignore[arg-type]
        else:
            source = rng.randrange(n) if n else 0
            out[at:at] = out[source : source + long * 16]
    return bytes(out)


def table(rng: Random, rows: list[list[str]]) -> bytes:
    """Return a CSV with a few changed rows."""
    rows = [list(row) for row in rows]
    for _ in range(rng.choice((1, 1, 2, 3))):
        row = rng.choice(rows) if rows else []
        kind = rng.randrange(8)
        if kind <= 3 and row:
            row[rng.randrange(len(row))] = rng.choice((text(rng), str(rng.choice(NUMBERS))))
        elif kind == 4:
            rows.insert(rng.randrange(len(rows) + 1), list(row))
        elif kind == 5 and row:
            del row[rng.randrange(len(row))]
        elif kind == 6 and rows:
            del rows[rng.randrange(len(rows))]
        elif rows:  # a whole column
            column = rng.randrange(max(1, len(rows[0])))
            new = rng.choice((text(rng), str(rng.choice(NUMBERS))))
            for other in rows[1:]:
                if column < len(other):
                    other[column] = new
    quoted = ("," if rng.random() < 0.95 else ";").join
    made = "\n".join(
        quoted(f'"{c}"' if set(c) & set(',"\n') and rng.random() < 0.9 else c for c in row)
        for row in rows
    )
    out = (made + "\n").encode(errors="surrogatepass")
    return raw(rng, out) if rng.random() < 0.15 else out


def array(rng: Random, old: NDArray[Any]) -> NDArray[Any]:
    """Return an array with damaged values, shape or type, without objects."""
    changes: tuple[Callable[[], NDArray[Any]], ...] = (
        lambda: _spoiled(rng, old),
        lambda: _spoiled(rng, old),
        lambda: old[..., None],
        lambda: old.reshape(-1),
        lambda: old[:0],
        lambda: np.array(rng.choice(NUMBERS), dtype=object).astype(np.float64),
        lambda: np.zeros((0, *old.shape[1:]), old.dtype),
        lambda: np.zeros((1,) * rng.choice((0, 1, 3, 32))),
        lambda: old.astype(rng.choice(("f2", "f4", "f8", ">f8", "c16", "U5", "S5", "?"))),
        lambda: np.full(old.shape, rng.choice(("", "x" * 500, "1e999", "\x1b[2J"))),
        lambda: np.concatenate([old, old]) if old.ndim else np.array([old, old]),
        lambda: old.T,
        lambda: old[:1],
        lambda: np.zeros(old.shape, rng.choice(("M8[s]", "m8[ns]", "V7", "i8", "u8", "i1"))),
    )
    with np.errstate(all="ignore"):
        try:
            return rng.choice(changes)()
        except (ValueError, TypeError, IndexError):
            return _spoiled(rng, old)


def _spoiled(rng: Random, old: NDArray[Any]) -> NDArray[Any]:
    """Return the array with one or all values replaced."""
    if old.dtype.kind not in "iuf" or not old.size:
        return np.array([text(rng)] * max(1, old.size))
    new = old.copy()
    rows = ... if rng.random() < 0.4 else rng.randrange(new.size)
    if new.dtype.kind == "f":
        numbers = (np.nan, np.inf, -np.inf, 0.0, -1.0, 1e-45, 1e-300, 1e30, 1e38, 1.7e308, 0.5)
        new.reshape(-1)[rows] = rng.choice(numbers)
    else:
        info = np.iinfo(new.dtype)
        new.reshape(-1)[rows] = rng.choice((0, -1 if info.min else 1, info.min, info.max))
    return new
