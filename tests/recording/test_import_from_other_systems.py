"""Files as spreadsheets, loggers, macOS and Windows write them are imported like our own."""

import numpy as np
import pytest
from import_files import RATE, imported, long_csv, table, wavs

from firstcontact.collect.guide import read_plan
from firstcontact.core.quantity import MODULUS, STIFFNESS
from firstcontact.recording import load_dataset

LABELS = "file,object,shore_a\n0.wav,foam,10\n1.wav,wood,80\n2.wav,cork,40\n"


@pytest.mark.parametrize(
    "labels",
    [
        LABELS.replace("\n", "\r\n") + ",,\r\n , ,\r\n",
        LABELS.replace("\n", ",,\n"),
        LABELS.replace("\n", "\n,,\n"),
        "\ufeff" + LABELS.replace("file,object,shore_a", "File,Object,Shore A"),
        LABELS.replace(".wav", ".WAV").replace("1.W", "wav\\1.w").replace("2.W", ".\\WAV\\2.w"),
        LABELS.replace("1.wav", "./wav/1.wav"),
        "# touched by hand\n% in May\n\n" + LABELS,
        "List of files\n\n" + LABELS + "# the end\n" + "\0" * 512,
        LABELS.replace("file", "# file", 1),
        LABELS.replace("shore_a", "Shore-A (Shore A)"),
    ],
    ids=range(10),
)
def test_tables_of_other_programs_are_read(tmp_path, labels):
    folder = wavs(tmp_path)
    (folder / "labels.csv").unlink()
    (folder / "Labels.CSV").write_text(labels, encoding="utf-8", newline="")
    dataset = imported(folder, tmp_path / "out", "--source", "real")
    assert dataset.objects.tolist() == ["foam", "wood", "cork"]
    assert dataset.shore_a.tolist() == [10, 80, 40]
    assert not any("unknown columns" in note for note in dataset.notes)


@pytest.mark.parametrize("end", [",,\n,,,,,,\n", ",\n"])
def test_plans_may_have_empty_rows_and_columns(tmp_path, end):
    path = tmp_path / "plan.csv"
    path.write_text("Object,Pinches,Shore,Specimen,Role\nfoam,2,10,foam,train\n".replace("\n", end))
    assert [(item.object, item.pinches) for item in read_plan(path)] == [("foam", 2)]


@pytest.mark.parametrize("events", [False, True])
def test_hidden_files_of_other_systems_are_no_data(tmp_path, events):
    folder = wavs(tmp_path)
    for path in [*folder.rglob("*.*")]:
        path.with_name(f"._{path.name}").write_bytes(b"\x00\x05\x16\x07" + bytes(200))
    (folder / ".Trashes").mkdir()
    (folder / ".Trashes" / "0.wav").write_bytes(b"")
    options = ()
    if events:
        path = table(tmp_path / "e.csv", {"file": ["0.wav", "1.wav"], "onset_sample": [20, 20]})
        options = ("--events", str(path))
    dataset = imported(folder, tmp_path / "out", *options)
    assert len(dataset) == (2 if events else 3)
    for path in [*(tmp_path / "out").glob("*.mcap")]:
        path.with_name(f"._{path.name}").write_bytes(bytes(200))
    assert load_dataset(tmp_path / "out").notes == dataset.notes


def test_a_name_that_fits_two_files_is_refused(tmp_path, check_refused):
    folder = wavs(tmp_path)
    (folder / "WAV").mkdir()
    (folder / "wav" / "0.wav").rename(folder / "WAV" / "0.wav")
    (folder / "WAV" / "1.WAV").write_bytes((folder / "wav" / "1.wav").read_bytes())
    table(folder / "labels.csv", {"file": ["0.wav", "2.wav", "1.Wav"]})
    check_refused(folder, "labels.csv", "'1.Wav'")


@pytest.mark.parametrize(
    ("name", "factor"),
    [("time_ms", 1e3), ("Time (us)", 1e6), ("time [s]", 1), ("time_µs", 1e6), ("t (ms)", 1e3)],
)
@pytest.mark.parametrize("preamble", ["", "#Rate: 5000 Hz\n", "Acquisition\nof,channel,A\n\n"])
def test_times_have_the_unit_of_their_name(tmp_path, name, factor, preamble):
    times = [round(i * factor / RATE, 3) for i in range(10)]
    path = long_csv(tmp_path, time_s=None, **{name: times if factor > 1 else np.arange(10) / RATE})
    path.write_text(preamble + path.read_text(encoding="utf-8"), encoding="utf-8")
    assert imported(path, tmp_path / "out").layout.rate == pytest.approx(RATE)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"closing_speed (km/h)": [20] * 10}, ("closing_speed", "'km/h'", "m/s")),
        ({"stiffness (N)": [20] * 10}, ("stiffness_n_per_mm", "'N'", "N/mm")),
        ({"shore_a": None, "modulus (mPa)": [2] * 10}, ("modulus_mpa", "'mPa'", "MPa")),
        ({"piezo_index": None, "accelerometer_index": [0] * 10}, ("unit",)),
        ({"shore_a": None, "Shore A (HD)": [20] * 10}, ("shore_a", "'HD'")),
        ({"piezo_unit": ["counts"] * 10, "piezo_thumb (V)": [0] * 10}, ("counts and V",)),
        ({"time_ms": range(10)}, ("'time_s' twice",)),
        ({"TIME_S": range(10)}, ("'time_s' twice",)),
        ({"Time (h)": range(10), "time_s": None}, ("rate",)),
    ],
)
def test_units_that_would_change_a_number_are_refused(tmp_path, check_refused, changes, words):
    check_refused(long_csv(tmp_path, **changes), "long.csv", *words)


@pytest.mark.parametrize(
    ("name", "value", "stated"),
    [
        ("stiffness (N/m)", 15_000, 15.0),
        ("Stiffness [kN/m]", 15, 15.0),
        ("stiffness_n_per_mm (N/um)", 0.015, 15.0),
        ("stiffness (N/µm)", 0.015, 15.0),
        ("Young's modulus (kPa)", 2000, 2.0),
        ("modulus_mpa", 2, 2.0),
        ("modulus (N/mm2)", 2, 2.0),
    ],
)
def test_labels_have_the_unit_of_their_name(tmp_path, name, value, stated):
    made = imported(long_csv(tmp_path, shore_a=None, **{name: [value] * 10}), tmp_path / "out")
    quantity, number = made[0].label.value
    assert number == pytest.approx(stated)
    assert quantity is (STIFFNESS if "tiff" in name else MODULUS)


def test_two_quantities_in_a_table_are_refused(tmp_path, check_refused):
    columns = {"shore_a": [20] * 10, "stiffness_n_per_mm": [5] * 10}
    check_refused(long_csv(tmp_path, **columns), "long.csv", "shore_a and stiffness_n_per_mm")


@pytest.mark.parametrize(
    ("name", "factor"),
    [("accelerometer (g)", 9.80665), ("accelerometer_mg", 9.80665e-3), ("accelerometer [m/s2]", 1)],
)
def test_accelerations_are_converted_to_m_s2(tmp_path, name, factor):
    columns = {"piezo_index": None, name: np.arange(10) % 3}
    made = imported(long_csv(tmp_path, **columns), tmp_path / "out")
    assert made.layout.vibration_unit == "m/s2"
    assert made[0].vibration().max() == pytest.approx(2 * factor, rel=1e-6)


@pytest.mark.parametrize(("factor", "unit"), [(1e3, "time_ms"), (1e6, "time_us")])
def test_times_that_cannot_be_seconds_name_their_probable_unit(
    tmp_path, check_refused, factor, unit
):
    path = long_csv(tmp_path, time_s=np.arange(10) * factor / RATE)
    check_refused(path, "time_s", unit)


def lines_of(stamps, path):
    signal = np.arange(len(stamps)) % 7
    cells = {"pinch": [0] * len(stamps), "time_s": stamps, "piezo_index": signal}
    return table(path, cells)


@pytest.mark.parametrize("form", ["{:.3f}", "{:g}", "{:.4f}", "{:.5f}", "{:.6f}", "f32"])
@pytest.mark.parametrize("rate", [5000, 8000, 44100])
@pytest.mark.parametrize("samples", [1000, 200_000])
def test_a_rounded_time_column_gives_the_exact_rate_or_asks_for_it(
    tmp_path, check_refused, form, rate, samples
):
    times = 120.0 + np.arange(samples) / rate
    stamps = times.astype("f4").astype(str) if form == "f32" else [*map(form.format, times)]
    path = lines_of(stamps, tmp_path / "x.csv")
    given = imported(path, tmp_path / "given", "--rate", str(rate))
    assert (given.layout.rate, len(given[0].data)) == (rate, samples)
    rounding = {"{:.3f}": 1e-3, "{:g}": 1e-3, "{:.4f}": 1e-4}.get(form, 0)
    if (rounding if rate * rounding > 1 else 0) > 1e-3 * samples / rate:
        check_refused(path, "x.csv", "time_s", "--rate")
    else:
        assert imported(path, tmp_path / "out").layout.rate == pytest.approx(rate, rel=1e-6)


@pytest.mark.parametrize(
    ("form", "lost"),  # a loss that is shorter than the rounding cannot be seen
    [("{:.3f}", 50), *((form, lost) for form in ("{:.4f}", "{:.6f}") for lost in (1, 2, 5, 50))],
)
def test_losses_between_rounded_times_are_refused(tmp_path, check_refused, form, lost):
    times = 120.0 + np.delete(np.arange(1000), np.s_[500 : 500 + lost]) / 5000
    path = lines_of([*map(form.format, times)], tmp_path / "x.csv")
    check_refused(path, "x.csv", "time_s", rate=5000)


def test_a_rate_that_rounded_times_contradict_is_refused(tmp_path, check_refused):
    path = lines_of([f"{i / 5000:.3f}" for i in range(1000)], tmp_path / "x.csv")
    check_refused(path, "x.csv", "'time_s' states", "4800", rate=4800)


@pytest.mark.parametrize(
    ("name", "scale"),
    [("Piezo Index (mV)", 1e-3), ("piezo_index_uV", 1e-6), ("piezo_index [V]", 1.0)],
)
def test_signals_have_the_unit_of_their_name(tmp_path, name, scale):
    values = [0, 3, -1, 4, -1, 5, -9, 2, 6, 5]
    path = long_csv(tmp_path, piezo_index=None, **{name: values})
    volts = np.concatenate([p.vibration()[:, 0] for p in imported(path, tmp_path / "out")])
    assert volts == pytest.approx(np.array(values) * scale)
