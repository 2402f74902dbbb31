// Sketch for two fingertips on a Teensy 4.0 or 4.1, each with a piezo, a 3 x 2 force array and a
// contact strip. With a model in its flash it predicts by itself, with or without a computer: see
// own_hand.cpp.
//
// THIS SKETCH HAS NOT RUN ON HARDWARE. It compiles against a stub of the Teensy's headers and runs on
// a PC with a simulated board. The code that it calls is tested on an emulated Cortex-M7. Pins,
// converter, timer, USB, EEPROM and flash are untested.
//
// Open it from firmware/build/firstcontact/, which `make -C firmware sketch-folder` makes: the IDE
// needs the other sources in the same folder.

#include <avr/eeprom.h>

#include "fc_predictor.h"
#include "fc_layout.h"
#include "model_flash.h"
#include "own_hand.h"
#include "sampling.h"

#if defined(ARDUINO_TEENSY41)
#define BOARD "teensy41"
#else
#define BOARD "teensy40"
#endif

static const uint32_t RING = 4096;     // 0.83 s while the host does not read
static const uint32_t LISTENERS = 512; // 0.1 s while estimates are late

static const char descriptor[] = FC_DESCRIPTOR_TEXT(BOARD, "real");
DMAMEM static fc_sample slots[RING];
static fc_sample waiting[LISTENERS];
static fc_device device;
static fc_predictor predictor;
// The active model is in RAM1, which needs no wait states. Flash would take several times as long,
// and RAM2 has a cache that is smaller than the model.
static uint8_t model[MODEL_BYTES] __attribute__((aligned(8)));

// Return a number that differs after each start.
static uint32_t count_boot() {
  uint32_t *const place = nullptr; // the EEPROM's first word
  const uint32_t boot = eeprom_read_dword(place) + 1;
  eeprom_write_dword(place, boot);
  return boot;
}

static uint32_t clock_ns() {
  return 1000 * micros();
}

// No Serial.begin(): USB runs already, and begin() would wait for a computer.
void setup() {
  static const fc_board board = {clock_ns, model, sizeof model, on_event};
  begin_own_hand();
  fc_device_init(&device, descriptor, count_boot(), slots, RING);
  if (const fc_memory *const memory = model_flash()) {
    fc_device_copy_samples(&device, waiting, LISTENERS);
    fc_predictor_init(&predictor, &device, memory, &board);
  }
  start_sampling(&device);
}

// Nothing here waits. The timer's interrupt takes the samples.
void loop() {
  while (fc_device_can_receive(&device) && Serial.available() > 0) {
    fc_device_receive(&device, (uint8_t)Serial.read());
  }
  size_t n;
  const uint8_t *const bytes = fc_device_outgoing(&device, &n);
  const int room = Serial.availableForWrite(); // 0 if no host reads
  if (n > 0 && room > 0) {
    fc_device_sent(&device, Serial.write(bytes, n < (size_t)room ? n : (size_t)room));
  }
  if (device.own_samples.size > 0) {
    fc_predictor_work(&predictor);
  }
}
