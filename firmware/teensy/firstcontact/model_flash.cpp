#include "model_flash.h"

#include <Arduino.h>
#include <string.h>

#include "sampling.h"

extern "C" {
// Functions of Teensyduino's core that its LittleFS uses: write up to a page into erased flash, and
// erase a sector. They run from RAM with interrupts off, because the program cannot be read
// meanwhile.
void eepromemu_flash_write(void *address, const void *bytes, uint32_t n);
void eepromemu_flash_erase_sector(void *address);
extern unsigned long _flashimagelen; // its address is the program's length
}

static const uintptr_t FLASH_BEGIN = 0x60000000;
#if defined(ARDUINO_TEENSY41)
static const uintptr_t FLASH_END = 0x607C0000;
#elif defined(ARDUINO_TEENSY40)
static const uintptr_t FLASH_END = 0x601F0000;
#else
#error "only the Teensy 4.0 and 4.1 are known"
#endif
static const uintptr_t MODELS = FLASH_END - 2 * MODEL_ROOM;
static const uint32_t SECTOR = 4096, PAGE = 256;

static uint32_t erased; // erased bytes of the slot that is being written

static uint8_t *at(int slot, uint32_t offset) {
  return reinterpret_cast<uint8_t *>(MODELS + (uintptr_t)slot * MODEL_ROOM + offset);
}

static const uint8_t *read_slot(void *, int slot) {
  return at(slot, 0);
}

// Erase the slot up to this length, one sector at a time as needed. Erasing all at once would take a
// second, longer than a host waits for a reply.
static void erase(int slot, uint32_t length) {
  for (; erased < length; erased += SECTOR) {
    pause_sampling();
    eepromemu_flash_erase_sector(at(slot, erased));
    resume_sampling();
  }
}

// The first sector holds the head. Without it the slot holds no model.
static bool clear_slot(void *, int slot) {
  erased = 0;
  erase(slot, SECTOR);
  return true;
}

static bool write_slot(void *, int slot, uint32_t offset, const uint8_t *bytes, uint32_t n) {
  const uint32_t end = offset + n;
  erase(slot, end);
  while (n > 0) {
    // A write beyond the end of a page would wrap to its beginning.
    const uint32_t room = PAGE - offset % PAGE, part = n < room ? n : room;
    pause_sampling();
    eepromemu_flash_write(at(slot, offset), bytes, part);
    resume_sampling();
    if (memcmp(at(slot, offset), bytes, part) != 0) {
      return false;
    }
    offset += part;
    bytes += part;
    n -= part;
  }
  return true;
}

const fc_memory *model_flash() {
  static const fc_memory memory = {nullptr, MODEL_ROOM, read_slot, clear_slot, write_slot};
  const uintptr_t program = FLASH_BEGIN + reinterpret_cast<uintptr_t>(&_flashimagelen);
  return program <= MODELS ? &memory : nullptr;
}
