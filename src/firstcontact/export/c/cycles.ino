// Prints the number of cycles of the chain's costliest sample on this board.
// Written by `firstcontact export-model`. It compiles against a stub of the Teensy's headers.
#include <fc_model_image.h>

#define DEMCR (*(volatile uint32_t *)0xe000edfcu)
#define DWT_CTRL (*(volatile uint32_t *)0xe0001000u)
#define DWT_COUNT (*(volatile uint32_t *)0xe0001004u)

static void print_cycles(const char *name, uint32_t cycles) {
  Serial.print(name);
  Serial.print(": cycles ");
  Serial.println(cycles);
}

// A decaying oscillation.
static inline void fill(float *window, int n) {
  float x = 0.0f, y = 0.5f;
  for (int k = 0; k < n; k++) {
    window[k] = x;
    x += 0.38f * y;
    y = 0.97f * (y - 0.38f * x);
  }
}

static void on_event(void *, const fc_event *event) {
  Serial.print("event ");
  Serial.print((int)event->kind);
  Serial.print(" estimate ");
  Serial.print(event->estimate.value, 1);
  Serial.println("");
}

static void run_chain() {
  static const int SIGNAL = 100;
  static float signal[SIGNAL];
  static fc_image image;
  static fc_chain chain;
  static double memory[FC_MODEL_MEMORY / 8];
  static const fc_program program = {nullptr, on_event, nullptr, nullptr, nullptr, {}};
  fc_stream stream = {};
  double volts[2], loads[1] = {0.0};
  uint32_t most = 0;
  stream.channels = 2;
  stream.finger[1] = 1;
  stream.alpha[0] = stream.alpha[1] = 1.0; // 0.5 for samples that are not smoothed yet
  const char *const fault = fc_image_read((const uint8_t *)fc_model_image, FC_MODEL_BYTES, &image);
  if (fault != nullptr) {
    Serial.println(fault);
    return;
  }
  fc_chain_init(&chain, &image, &stream, &program, memory);
  fc_chain_restart(&chain, 0, false); // without noise floors, a closing begins here
  fill(signal, SIGNAL);
  for (int k = 0; k < 8 * SIGNAL; k++) {
    volts[0] = k < 6 * SIGNAL ? 1e-3 * ((k * 37) % 17 - 8) : signal[k % SIGNAL];
    volts[1] = 1e-3 * ((k * 53) % 19 - 9);
    const uint32_t before = DWT_COUNT;
    fc_chain_take(&chain, volts, loads);
    const uint32_t cycles = DWT_COUNT - before;
    most = cycles > most ? cycles : most;
  }
  fc_chain_finish(&chain);
  print_cycles("costliest sample of the chain", most);
}

void setup() {
  Serial.begin(0);
  DEMCR |= 1u << 24;
  DWT_CTRL |= 1u;
}

void loop() {
  run_chain();
  delay(1000);
}
