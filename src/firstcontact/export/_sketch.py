"""Example sketch of an exported library, which counts the cycles of predictions on the board."""

from __future__ import annotations

from firstcontact.export._trained import Trained

_TEXT = """\
// Prints how many cycles an answer takes on this board, counted by its own cycle counter.
//
// Written by `firstcontact export-model`; it compiles against a stub of the Teensy's headers.
@INCLUDES@

#define DEMCR (*(volatile uint32_t *)0xe000edfcu)
#define DWT_CTRL (*(volatile uint32_t *)0xe0001000u)
#define DWT_COUNT (*(volatile uint32_t *)0xe0001004u)

// A decaying swing at 300 Hz: any window does, for what it takes does not depend on it.
static inline void fill(float *window, int n) {
  float x = 0.0f, y = 0.5f;
  for (int k = 0; k < n; k++) {
    window[k] = x;
    x += 0.38f * y;
    y = 0.97f * (y - 0.38f * x);
  }
}

static void tell(const char *what, uint32_t cycles) {
  Serial.print(what);
  Serial.print(": cycles ");
  Serial.println(cycles);
}

void setup() {
  Serial.begin(0);
  DEMCR |= 1u << 24;
  DWT_CTRL |= 1u;
}

void loop() {
@ROUNDS@  delay(1000);
}
"""

_ROUND = """\
  {{
    static float window[FC_{upper}_SAMPLES * FC_{upper}_CHANNELS];
    fc_estimate answer = {{0.0, 0.0, 0.0, -1}};
    fill(window, FC_{upper}_SAMPLES * FC_{upper}_CHANNELS);
    const uint32_t before = DWT_COUNT;
    (void)fc_{name}(window, &answer);
    tell("fc_{name}", DWT_COUNT - before);
  }}
"""

_DETECTOR = """\
  {
    static fc_detector detector;
    fc_contact contacts[FC_CHANNELS];
    double volts[FC_CHANNELS];
    uint32_t most = 0, steady = 0;
    fc_detector_start(&detector, 0);
    for (int32_t n = 0; n < 2 * FC_STEADY; n++) {
      for (int32_t c = 0; c < FC_CHANNELS; c++) {
        volts[c] = 1e-3 * ((n * 37 + c * 11) % 17 - 8);
      }
      const uint32_t before = DWT_COUNT;
      (void)fc_detector_take(&detector, volts, contacts);
      const uint32_t took = DWT_COUNT - before;
      // The steady state is taken in by the sample that completes it and the two after it.
      uint32_t *const its = n + 1 >= FC_STEADY && n < FC_STEADY + 2 ? &steady : &most;
      *its = took > *its ? took : *its;
    }
    tell("fc_detector_take, dearest sample that takes in a steady state", steady);
    tell("fc_detector_take, dearest other sample", most);
  }
"""

_ANYTIME = """\
  {
    static float signal[FC_BEFORE + FC_LONGEST];
    static fc_touch touch;
    fc_running answer = {0.0, 0.0, 0.0, 0.0, false};
    fill(signal, FC_BEFORE + FC_LONGEST);
    fc_anytime_begin(&fc_anytime_model, &touch, signal, 0);
    for (int32_t k = 0; k < FC_LONGEST; k++) {
      fc_anytime_take(&touch, signal[FC_BEFORE + k]);
    }
    const uint32_t before = DWT_COUNT;
    (void)fc_anytime_answer(&fc_anytime_model, &touch, &answer);
    tell("fc_anytime_answer", DWT_COUNT - before);
  }
"""


def sketch(trained: Trained) -> str:
    """Return an Arduino sketch that runs every exported part."""
    names = [f"fc_{m.name}" for m in trained.models]
    rounds = [_ROUND.format(name=m.name, upper=m.name.upper()) for m in trained.models]
    if trained.detector is not None:
        names.append("fc_detector")
        rounds.append(_DETECTOR)
    if trained.anytime is not None:
        names.append("fc_anytime_model")
        rounds.append(_ANYTIME)
    includes = "\n".join(f"#include <{name}.h>" for name in names)
    return _TEXT.replace("@INCLUDES@", includes).replace("@ROUNDS@", "".join(rounds))
