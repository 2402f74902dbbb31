// Simulated USB on a pseudo terminal, and Serial1 in a file.
#include <Arduino.h>

#include "board.h"

#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

usb_serial_class Serial;
HardwareSerial Serial1;

size_t Print::print(const char *text) {
  return write(reinterpret_cast<const uint8_t *>(text), strlen(text));
}

size_t Print::print(int number) {
  char text[16];
  snprintf(text, sizeof text, "%d", number);
  return print(text);
}

size_t Print::print(double number, int digits) {
  char text[64];
  snprintf(text, sizeof text, "%.*f", digits, number);
  return print(text);
}

size_t Print::println(const char *text) {
  return print(text) + print("\r\n");
}

size_t Print::println(double number, int digits) {
  return print(number, digits) + print("\r\n");
}

int usb_serial_class::available() {
  line *const l = &board.usb;
  if (l->from == l->to) {
    const ssize_t n = ::read(l->fd, l->bytes, sizeof l->bytes);
    l->from = 0;
    l->to = n > 0 ? (size_t)n : 0;
  }
  return (int)(l->to - l->from);
}

int usb_serial_class::read() {
  return available() > 0 ? board.usb.bytes[board.usb.from++] : -1;
}

int usb_serial_class::availableForWrite() {
  struct pollfd takes = {board.usb.fd, POLLOUT, 0};
  return poll(&takes, 1, 0) > 0 && (takes.revents & POLLOUT) ? 2048 : 0;
}

size_t usb_serial_class::write(const uint8_t *bytes, size_t n) {
  const ssize_t sent = ::write(board.usb.fd, bytes, n);
  return sent > 0 ? (size_t)sent : 0;
}

void HardwareSerial::begin(uint32_t, uint16_t) {}

int HardwareSerial::availableForWrite() {
  return 63;
}

size_t HardwareSerial::write(const uint8_t *bytes, size_t n) {
  return board.serial1 >= 0 && ::write(board.serial1, bytes, n) == (ssize_t)n ? n : 0;
}
