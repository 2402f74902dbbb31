// Simulated flash: erased by sectors, written by pages, and a write only clears bits.
#include <avr/eeprom.h>

#include "board.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static const uintptr_t BEGIN = 0x60000000;
static const size_t SIZE = 1 << 21, EEPROM = 0x1F0000, SECTOR = 4096, PAGE = 256;
static unsigned long operations;

int open_flash(const char *path) {
  struct stat is;
  const int fd = open(path, O_RDWR | O_CREAT, 0666);
  if (fd < 0 || fstat(fd, &is) < 0) {
    return -1;
  }
  const bool fresh = is.st_size == 0;
  if (fresh && ftruncate(fd, SIZE) < 0) {
    return -1;
  }
  void *const at = mmap(reinterpret_cast<void *>(BEGIN), SIZE, PROT_READ | PROT_WRITE,
                        MAP_SHARED | MAP_FIXED_NOREPLACE, fd, 0);
  (void)close(fd);
  if (at == MAP_FAILED) {
    return -1;
  }
  if (fresh) {
    memset(at, 0xff, SIZE);
  }
  return 0;
}

// Return how much of an operation is done before the power fails.
static size_t until_cut(size_t n) {
  return ++operations == board.cut ? n / 2 : n;
}

static void go_on(uint64_t cycles) {
  if (operations == board.cut) {
    _exit(3);
  }
  // Interrupts are off: one that falls due meanwhile runs once, afterwards.
  board.cycles += cycles;
  (void)pass(0);
}

static void never(bool fault, const char *what) {
  if (fault) {
    fprintf(stderr, "flash: %s\n", what);
    abort();
  }
}

extern "C" void eepromemu_flash_write(void *address, const void *bytes, uint32_t n) {
  uint8_t *const to = static_cast<uint8_t *>(address);
  const uintptr_t at = reinterpret_cast<uintptr_t>(address);
  never(n == 0 || at % PAGE + n > PAGE, "a write beyond a page");
  for (size_t k = 0, most = until_cut(n); k < most; k++) {
    const uint8_t byte = static_cast<const uint8_t *>(bytes)[k];
    never((to[k] & byte) != byte, "a write into what was not erased");
    to[k] = byte;
  }
  go_on(PAGE_CYCLES);
}

extern "C" void eepromemu_flash_erase_sector(void *address) {
  never(reinterpret_cast<uintptr_t>(address) % SECTOR != 0, "an address within a sector");
  memset(address, 0xff, until_cut(SECTOR));
  go_on(SECTOR_CYCLES);
}

static uint32_t *eeprom(const uint32_t *place) {
  return reinterpret_cast<uint32_t *>(BEGIN + EEPROM + reinterpret_cast<uintptr_t>(place));
}

uint32_t eeprom_read_dword(const uint32_t *place) {
  return *eeprom(place);
}

void eeprom_write_dword(uint32_t *place, uint32_t value) {
  *eeprom(place) = value;
}
