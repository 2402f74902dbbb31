"""Predictions for one contact in NumPy, in double precision: what the chain must compute.

Only the integers of the network are rounded as in the chain.
"""

import math

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain.constants import Matrix, ModelConstants, ProcessConstants, RigConstants

Values = NDArray[np.float64]
POINTS, LEAST, SHIFT, TURN, EACH = 74, 1e-4, 88, 512, 4
NAMES = (
    "peak", "steepest rise", "time to peak", "time to a tenth", "time to a half", "width at half",
    "roughness", "undershoot", "time to undershoot", "power", "centre of energy", "length",
    "last value", "last slope", "noise", "repeats",
)  # fmt: skip
GAIN = np.isin(NAMES, ("peak", "steepest rise", "power", "noise"))


def predict(
    m: ModelConstants,
    rig: RigConstants,
    signal: Values,
    valid: int,
    speed: float = math.nan,
    error: float = math.nan,
    radius: float = math.nan,
) -> tuple[float, float, float, float, float, bool]:
    """Return value, low, high, half width, spread, and whether a contact is out of range."""
    stage = int(np.searchsorted(m.stages, min(valid, m.stages[-1])))
    before, after = signal[: m.before].astype(np.float64), rig.sign * signal[m.before :][:valid]
    found = traits(before, after, rig.level)
    hint = hints(m, rig, before, speed, error, radius)
    value, spread = network(m, rig.terms[stage], inputs(after, rig.level, found, hint))
    if rig.process is not None:
        value, spread = mixed(value, spread, *regressed(rig.process, found, hint, stage))
        value -= float(rig.process.offset[stage])
    half, value = spread * m.factors[stage], value
    shown = bounded(value, 0.0, 100.0)
    low, high = (bounded(shown + side * half, 0.0, 100.0) for side in (-1, 1))
    return shown, low, high, half, spread, is_unfamiliar(m, rig, found, stage)


def traits(before: Values, v: Values, level: float) -> Values:
    """Return the traits of a signal after the contact, positive in its first swing."""
    n, least = len(v), LEAST * level
    padded = np.zeros(POINTS)  # samples that are not there yet count as 0
    padded[:n] = v
    at = int(padded.argmax())
    peak = max(padded[at], least)
    steps = np.diff(v)
    relative = padded / peak
    fall = relative[at + 1 : n]
    low_at = at + 1 + int(fall.argmin()) if len(fall) else at
    total = float((v * v).sum()) + LEAST * LEAST * level * level
    noise = before[: len(before) // 2].std()
    return np.array(
        [
            math.log(peak / level),
            math.log(max(steps.max(), least) / level),
            at / 20 - 1,
            np.count_nonzero(relative[: at + 1] < 0.1) / 10 - 0.5,
            np.count_nonzero(relative[: at + 1] < 0.5) / 10 - 0.5,
            np.count_nonzero(relative > 0.5) / 20 - 0.5,
            math.log(float((steps * steps).sum()) / total + 1e-4) + 2,
            relative[low_at] if len(fall) else 1.0,
            low_at / 40 - 1,
            math.log(math.sqrt(total / n) / level),
            float((v * v) @ np.arange(n)) / total / 20 - 1,
            n / 37 - 1,
            relative[n - 1],
            relative[n - 1] - relative[max(n - 4, 0)],
            math.log(max(noise, 1e-7) / level),
            10 * np.count_nonzero(steps == 0.0) / (n - 1),
        ]
    )


def inputs(v: Values, level: float, found: Values, hint: Values) -> Values:
    """Return the inputs of the network."""
    out = np.zeros((3, POINTS))
    out[0, : len(v)] = np.copysign(np.log1p(np.abs(v) * (2 / level)), v) / 2
    out[1, : len(v)] = v / max(v.max(), LEAST * level)
    out[2, : len(v)] = 1.0
    return np.concatenate([out.ravel(), found[:-2], hint])


def hints(
    m: ModelConstants, rig: RigConstants, before: Values, speed: float, error: float, radius: float
) -> Values:
    """Return the inputs for closing speed and radius."""
    log, alike = 0.0, 0.0
    if rig.reference is not None:
        shift, alike = pitch(spectrum(m, before), rig.reference.astype(np.float64))
        log, alike = shift * m.pitch_step - rig.usual_pitch, bounded(alike, 0.0, 1.0)
    if rig.usual_speed > 0 and not math.isnan(speed):
        precision = 1 / max(0.0 if math.isnan(error) else error, 0.01) ** 2
        is_heard = alike > 0.5 and rig.heard_error > 0
        heard = 1 / rig.heard_error**2 if is_heard else 0.0
        measured = math.log(max(speed, 1e-6) / rig.usual_speed)
        total = precision + heard + 1 / rig.speed_spread**2
        log, alike = (precision * measured + heard * log) / total, 1.0
    curvature = 0.0 if math.isnan(radius) else math.log1p(0.010 / radius)
    believed = alike > 0.5
    return np.array(
        [4 * bounded(log, -1, 1) * believed, believed, alike, not math.isnan(radius), curvature]
    )


def spectrum(m: ModelConstants, before: Values) -> Values:
    """Return the peaks of a spectrum above its smooth part."""
    quiet = before[: len(m.fade)]
    power = np.abs(np.fft.rfft((quiet - quiet.mean()) * m.fade, TURN)) ** 2
    level = np.log(power[m.cell] * (1 - m.part) + power[m.cell + 1] * m.part + 1e-3)
    smooth = np.convolve(np.pad(level, 30, mode="edge"), np.ones(61) / 61, mode="valid")
    lines = np.maximum(level - smooth, -1.0)
    return np.asarray(lines - lines.mean())


def pitch(lines: Values, reference: Values) -> tuple[int, float]:
    """Return the shift against a reference that fits best, and the correlation there.

    Every fourth point gives a rough shift, and all points the best one near it.
    """
    rough = fits(lines[::EACH], reference[::EACH], range(-SHIFT // EACH, SHIFT // EACH + 1))
    middle = EACH * max(rough, key=lambda s: rough[s])
    near = fits(lines, reference, range(middle - EACH + 1, middle + EACH))
    best = max(near, key=lambda s: near[s] if abs(s) <= SHIFT else -math.inf)
    return best, near[best] / (lines.std() * reference.std() + 1e-9)


def fits(lines: Values, reference: Values, shifts: range) -> dict[int, float]:
    """Return the correlation at each shift, without the scale of the spectra."""
    n, fit = len(lines), {}
    for s in shifts:
        one, other = lines[max(s, 0) : n + min(s, 0)], reference[max(-s, 0) : n - max(s, 0)]
        fit[s] = float(one @ other) / math.sqrt((n - abs(s)) * n)
    return fit


def product(matrix: Matrix, x: Values) -> Values:
    """Return the product with a matrix of integers, after rounding the inputs to 15 bits."""
    most = float(np.abs(x).max())
    steps = x * (32767 / most if most > 1e-30 else 0.0)
    out: Values = matrix.weight.astype(np.float64) @ np.rint(steps) * matrix.scale * (most / 32767)
    return out


def network(m: ModelConstants, term: Values, x: Values) -> tuple[float, float]:
    """Return mean and spread of the mixture that the network predicts."""
    h = np.clip((x - m.mean) / m.sd, -6, 6)
    for number, layer in enumerate(m.layers):
        z = product(layer.into, h) + (term if number == 1 else 0.0)
        y = product(layer.out, z) + layer.bias
        h = y / (1 + np.exp(-np.maximum(y, -60)))
    weight, mean, spread = (m.answer @ h + m.answer_bias).astype(np.float64).reshape(3, 3)
    weight = np.exp(weight - weight.max())
    weight /= weight.sum()
    mean, sd = 40 + 40 * 0.6 * mean, 40 * np.exp(np.clip(spread, -4, 2))
    value = float(weight @ mean)
    variance = float(weight @ (sd * sd + mean * mean)) - value * value
    return value, math.sqrt(max(variance, 1e-4))


def regressed(p: ProcessConstants, found: Values, hint: Values, stage: int) -> tuple[float, float]:
    """Return value and spread of the Gaussian process of a rig."""
    x = np.append(found[:-2], hint[0]).clip(-10, 10)
    x = (x - p.mean[stage]) / p.sd[stage]
    known = p.known[stage]
    apart = ((known - x[:, None]) ** 2).sum(axis=0)
    covariance = 1 + known.T @ x / len(x) + np.exp(-apart / (8 * len(x)))
    explained = p.factor[stage] @ covariance
    left = max(2 + x @ x / len(x) - explained @ explained, 0.0)
    value = p.centre + p.unit * float(covariance @ p.weights[stage])
    return bounded(value, 0.0, 100.0), p.unit * math.sqrt(left + 0.3) * float(p.scale[stage])


def mixed(value: float, spread: float, other: float, own: float) -> tuple[float, float]:
    """Return mean and spread of two predictions, weighted by the inverse of their variances."""
    share = own**2 / (own**2 + spread**2)
    variance = share * spread**2 + (1 - share) * own**2
    apart = share * (1 - share) * (value - other) ** 2
    return share * value + (1 - share) * other, math.sqrt(variance + apart)


def is_unfamiliar(m: ModelConstants, rig: RigConstants, found: Values, stage: int) -> bool:
    """Return True if a contact is far from those of the training."""
    away = found - m.familiar[stage]
    away[NAMES.index("length")] = 0.0
    far = m.whitening[stage] @ away
    if not rig.has_level:  # take the gain with the smallest distance
        along = m.whitening[stage] @ GAIN
        far = far - along * (far @ along) / (along @ along)
        if found[-1] > 5.0:
            return True
    return bool(math.sqrt(far @ far) > m.limit[stage])


def bounded(x: float, low: float, high: float) -> float:
    """Return x within bounds."""
    return min(max(x, low), high)
