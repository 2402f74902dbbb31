// Main program that runs the Teensy's sketch on this machine.
#include <Arduino.h>

#include "board.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

Board board;

static const char usage[] =
    "usage: firstcontact-teensy --scans FILE|- --flash FILE [--serial1 FILE] [--busy-us N]\n"
    "                           [--unread yes] [--cut N]\n"
    "Prints the path of a pseudo terminal, which stands for the USB port, and runs the sketch with\n"
    "these scans: with --unread yes to their end, whoever reads.\n";

static bool parse(int argc, char **argv, const char **scans, const char **flash) {
  bool good = argc % 2 == 1;
  for (int i = 1; good && i + 1 < argc; i += 2) {
    const char *const value = argv[i + 1];
    if (strcmp(argv[i], "--scans") == 0) {
      *scans = value;
    } else if (strcmp(argv[i], "--flash") == 0) {
      *flash = value;
    } else if (strcmp(argv[i], "--serial1") == 0) {
      board.serial1 = open(value, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    } else if (strcmp(argv[i], "--busy-us") == 0) {
      board.busy_us = strtoul(value, nullptr, 10);
    } else if (strcmp(argv[i], "--unread") == 0) {
      board.unread = strcmp(value, "yes") == 0;
    } else if (strcmp(argv[i], "--cut") == 0) {
      board.cut = strtoul(value, nullptr, 10);
    } else {
      good = false;
    }
  }
  return good && *scans != nullptr && *flash != nullptr;
}

int main(int argc, char **argv) {
  const char *scans = nullptr, *flash = nullptr;
  if (!parse(argc, argv, &scans, &flash)) {
    fputs(usage, stderr);
    return 2;
  }
  const char *path = nullptr;
  if (feed_open(&board.scans, scans) < 0 || open_flash(flash) < 0
      || (path = line_open(&board.usb)) == nullptr) {
    fprintf(stderr, "the board cannot be made: %s\n", strerror(errno));
    return 2;
  }
  printf("%s\n", path);
  fflush(stdout);
  setup();
  for (;;) {
    // Time stops while the line is full, so that a slow reader causes no overflow.
    const bool goes_on = board.unread || Serial.availableForWrite() > 0;
    if (!goes_on || !pass_until_due()) {
      if (board.ended && board.unread) {
        return 0;
      }
      struct pollfd waits = {board.usb.fd, POLLIN, 0};
      (void)poll(&waits, 1, 1);
    }
    loop();
  }
}
