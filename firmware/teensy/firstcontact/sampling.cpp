#include "sampling.h"

#include <Arduino.h>

#include "fc_pace.h"
#include "pins.h"

#if TEENSYDUINO < 159
#error "Teensyduino is older than 1.59: its pads hold the voltage of analog pins. Update the board package."
#endif

// Clock of IntervalTimer: 24 MHz.
static const uint32_t TIMER_HZ = 24000000;
static const float TICKS_PER_MICROSECOND = 24.0f;

static fc_device *device;
static fc_pace pace;
static IntervalTimer timer;
static volatile uint32_t sampled_at; // time of the newest sample, cycles
static uint64_t owed;                // time without a sample number yet, cycles times rate

static float next_period() {
  return fc_pace_next(&pace) / TICKS_PER_MICROSECOND;
}

// Drive one row of each array and hold the others at ground: fc_means_step relies on it. The row
// settles until the next sample. The earlier row is grounded first, so that never two are driven.
static void select_taxel() {
  const uint8_t row = fc_scan_row(&device->scan);
  for (uint8_t f = 0; f < FC_FINGERS; f++) {
    for (uint8_t r = 0; r < 3; r++) {
      digitalWrite(ROW_PIN[f][r], LOW);
    }
    digitalWrite(ROW_PIN[f][row], HIGH);
  }
}

// Read a column behind 22 kOhm. The converter keeps some charge of the pin that it read before: the
// first reading takes it along, the second one counts. A reading takes some 4.5 us, so the six of a
// sample take 27 us of its 202.6 us.
static uint16_t read_column(uint8_t pin) {
  (void)analogRead(pin);
  return analogRead(pin);
}

static void take_sample() {
  sampled_at = ARM_DWT_CYCCNT;
  timer.update(next_period()); // applies to the period after the present one
  const uint8_t column = fc_scan_column(&device->scan);
  fc_raw raw;
  for (uint8_t f = 0; f < FC_FINGERS; f++) {
    raw.piezo[f] = analogRead(PIEZO_PIN[f]);
  }
  for (uint8_t f = 0; f < FC_FINGERS; f++) {
    raw.force[f] = read_column(COLUMN_PIN[f][column]);
    raw.strip[f] = digitalRead(STRIP_PIN[f]) == LOW; // the object is grounded
  }
  fc_device_sample(device, &raw);
  select_taxel();
}

void start_sampling(fc_device *fingertips) {
  device = fingertips;
  analogReadResolution(10);
  analogReadAveraging(1);
  for (uint8_t f = 0; f < FC_FINGERS; f++) {
    pinMode(STRIP_PIN[f], INPUT_PULLUP);
    // Without the keeper of the digital input, which pulls at voltages behind 22 kOhm.
    pinMode(PIEZO_PIN[f], INPUT_DISABLE);
    for (uint8_t c = 0; c < 2; c++) {
      pinMode(COLUMN_PIN[f][c], INPUT_DISABLE);
    }
    for (uint8_t r = 0; r < 3; r++) {
      pinMode(ROW_PIN[f][r], OUTPUT);
    }
  }
  fc_pace_init(&pace, TIMER_HZ, FC_RATE_HZ);
  select_taxel();
  delay(1); // let the first row settle
  sampled_at = ARM_DWT_CYCCNT;
  timer.begin(take_sample, next_period());
}

void pause_sampling() {
  timer.end();
}

void resume_sampling() {
  // The next sample is one period from now. A fraction of a period is carried to the next pause.
  owed += (uint64_t)(ARM_DWT_CYCCNT - sampled_at) * FC_RATE_HZ;
  fc_device_skip(device, (uint32_t)(owed / F_CPU_ACTUAL));
  owed %= F_CPU_ACTUAL;
  select_taxel();
  sampled_at = ARM_DWT_CYCCNT;
  timer.begin(take_sample, next_period());
}
