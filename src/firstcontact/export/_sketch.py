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
@EVENTS@
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
    fc_answer answer = {{0.0, 0.0, 0.0, -1}};
    fill(window, FC_{upper}_SAMPLES * FC_{upper}_CHANNELS);
    const uint32_t before = DWT_COUNT;
    (void)fc_{name}(window, &answer);
    tell("fc_{name}", DWT_COUNT - before);
  }}
"""

_CHAIN = """\
  {
    static fc_image image;
    static fc_chain chain;
    static double memory[FC_MODEL_MEMORY / 8];
    static const fc_program program = {nullptr, on_event, nullptr, nullptr, nullptr, {}};
    fc_stream stream = {};
    double volts[2], loads[1] = {0.0};
    stream.channels = 2;
    stream.finger[1] = 1;
    stream.alpha[0] = stream.alpha[1] = 1.0; // 0.5 for samples that are not smoothed yet
    const uint8_t *const bytes = (const uint8_t *)fc_model_image;
    const char *const fault = fc_image_read(bytes, FC_MODEL_BYTES, &image);
    if (fault != nullptr) {
      Serial.println(fault);
    } else {
      fc_chain_init(&chain, &image, &stream, &program, memory);
      fc_chain_restart(&chain, 0, false); // without noise floors, this begins a closing
      fill(signal, SIGNAL);
      for (int k = 0; k < 8 * SIGNAL; k++) {
        volts[0] = k < 6 * SIGNAL ? 1e-3 * ((k * 37) % 17 - 8) : signal[k % SIGNAL];
        volts[1] = 1e-3 * ((k * 53) % 19 - 9);
        const uint32_t before = DWT_COUNT;
        fc_chain_take(&chain, volts, loads);
        const uint32_t took = DWT_COUNT - before;
        most = took > most ? took : most;
      }
      fc_chain_finish(&chain);
      tell("dearest sample of the chain", most);
      most = 0;
    }
  }
"""
_EVENTS = """
static const int SIGNAL = 100;
static float signal[SIGNAL];
static uint32_t most;

static void on_event(void *, const fc_event *event) {
  Serial.print("event ");
  Serial.print((int)event->kind);
  Serial.print(" estimate ");
  Serial.print(event->estimate.value, 1);
  Serial.println("");
}
"""


def sketch(trained: Trained) -> str:
    """Return an Arduino sketch that runs every exported part."""
    names = [f"fc_{m.name}" for m in trained.models]
    rounds = [_ROUND.format(name=m.name, upper=m.name.upper()) for m in trained.models]
    if trained.has_chain:
        names.append("fc_model_image")
        rounds.append(_CHAIN)
    includes = "\n".join(f"#include <{name}.h>" for name in names)
    events = _EVENTS if trained.has_chain else ""
    text = _TEXT.replace("@INCLUDES@", includes).replace("@EVENTS@", events)
    return text.replace("@ROUNDS@", "".join(rounds))
