"""The example of an exported library: it counts what an answer costs on the board itself."""

from __future__ import annotations

from firstcontact.embedded.trained import Trained

_TEXT = """\
// Prints how many cycles an answer takes on this board, counted by its own cycle counter.
//
// Written by `firstcontact export-model`; it compiles against a stub of the Teensy's headers.
@INCLUDES@

#define DEMCR (*(volatile uint32_t *)0xe000edfcu)
#define DWT_CTRL (*(volatile uint32_t *)0xe0001000u)
#define DWT_COUNT (*(volatile uint32_t *)0xe0001004u)

// A decaying swing at 300 Hz: any window does, for what it takes does not depend on it.
static void fill(float *window, int n) {
  float x = 0.0f, y = 0.5f;
  for (int k = 0; k < n; k++) {
    window[k] = x;
    x += 0.38f * y;
    y = 0.97f * (y - 0.38f * x);
  }
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
    const fc_status status = fc_{name}(window, &answer);
    const uint32_t cycles = DWT_COUNT - before;
    Serial.printf("fc_{name}: %lu cycles, status %d, value %d\\n", (unsigned long)cycles,
                  (int)status, (int)answer.value);
  }}
"""


def sketch(trained: Trained) -> str:
    """An Arduino sketch that asks every model of a training."""
    includes = "\n".join(f"#include <fc_{m.name}.h>" for m in trained.models)
    rounds = "".join(_ROUND.format(name=m.name, upper=m.name.upper()) for m in trained.models)
    return _TEXT.replace("@INCLUDES@", includes).replace("@ROUNDS@", rounds)
