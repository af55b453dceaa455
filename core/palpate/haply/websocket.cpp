#include "palpate/haply/websocket.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <random>

#include "palpate/loop/realtime.hpp"

namespace palpate::haply {
namespace {

enum Opcode : unsigned { kContinuation = 0, kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10 };

constexpr std::size_t kLongestControl = 125;  // bytes of the payload of a control frame

}  // namespace

WebSocket::WebSocket(int socket) : socket_(socket), mask_(std::random_device{}() | 1u) {
  const int on = 1;
  setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
}

WebSocket::~WebSocket() {
  const char normal[2] = {3, static_cast<char>(232)};  // 1000: normal closure
  send_frame(kClose, {normal, sizeof(normal)});
  ::close(socket_);
}

bool WebSocket::send(std::string_view text) noexcept { return send_frame(kText, text); }

bool WebSocket::send_frame(unsigned opcode, std::string_view payload) noexcept {
  if (broken_ || payload.size() > kLargest) return false;
  // The real-time thread never waits for the watchdog, which has a lower priority and may not run meanwhile: its forces
  // do not meet the watchdog's zero (Device::write), and a pong that does is left out.
  while (sending_.test_and_set(std::memory_order_acquire)) {
    if (opcode == kPong) return true;
  }
  mask_ = mask_ * 1664525u + 1013904223u;
  char mask[4];
  std::memcpy(mask, &mask_, 4);
  const std::size_t n = payload.size();
  std::size_t head = 0;
  out_[head++] = static_cast<char>(0x80u | opcode);
  if (n < 126) {
    out_[head++] = static_cast<char>(0x80u | n);
  } else {
    const bool wide = n > 0xffff;
    out_[head++] = static_cast<char>(0x80u | (wide ? 127u : 126u));
    for (int byte = wide ? 7 : 1; byte >= 0; --byte) out_[head++] = static_cast<char>(n >> (8 * byte));
  }
  std::memcpy(out_.data() + head, mask, 4);
  head += 4;
  for (std::size_t i = 0; i < n; ++i) out_[head + i] = static_cast<char>(payload[i] ^ mask[i & 3]);
  const ssize_t sent = ::send(socket_, out_.data(), head + n, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent != static_cast<ssize_t>(head + n)) broken_ = true;  // a part of a frame cannot be taken back
  sending_.clear(std::memory_order_release);
  return !broken_;
}

WebSocket::Got WebSocket::receive(std::int64_t timeout) noexcept {
  const std::int64_t end = loop::now_ns() + timeout;
  if (!partial_) length_ = 0;
  for (;;) {
    if (broken_) return Got::broken;
    const Got frame = take_frame();
    if (frame != Got::nothing) return frame;
    const Got data = wait(end - loop::now_ns());
    if (data != Got::message) return data;
  }
}

// Fills in_; Got::message if there are new bytes.
WebSocket::Got WebSocket::wait(std::int64_t timeout) noexcept {
  if (begin_ > 0) {
    std::memmove(in_.data(), in_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  for (;;) {
    const ssize_t got = ::recv(socket_, in_.data() + end_, in_.size() - end_, MSG_DONTWAIT);
    if (got > 0) {
      end_ += static_cast<std::size_t>(got);
      return Got::message;
    }
    if (got == 0) return broken_ = true, Got::closed;
    if (errno == EINTR) continue;
    if (errno != EAGAIN && errno != EWOULDBLOCK) return broken_ = true, Got::broken;
    if (timeout <= 0) return Got::nothing;
    const timespec left{timeout / 1'000'000'000, timeout % 1'000'000'000};
    pollfd watched{socket_, POLLIN, 0};
    if (::ppoll(&watched, 1, &left, nullptr) == 0) return Got::nothing;
  }
}

// Takes frames from in_ until a message is whole; Got::nothing if bytes are missing.
WebSocket::Got WebSocket::take_frame() noexcept {
  const auto broken = [this] { return broken_ = true, Got::broken; };
  const auto byte = [this](std::size_t i) { return static_cast<unsigned char>(in_[begin_ + i]); };
  while (end_ - begin_ >= 2) {
    const unsigned opcode = byte(0) & 0x0fu;
    const bool last = (byte(0) & 0x80u) != 0, control = opcode >= kClose;
    if ((byte(0) & 0x70u) != 0 || (byte(1) & 0x80u) != 0) return broken();  // an extension, or a masked frame
    std::size_t n = byte(1) & 0x7fu, head = 2;
    const std::size_t wide = n < 126 ? 0 : n == 126 ? 2 : 8;
    if (end_ - begin_ < head + wide) return Got::nothing;
    if (wide > 0) n = 0;
    for (std::size_t i = 0; i < wide; ++i) {
      n = n << 8 | byte(head + i);
      if (n > kLargest) return broken();
    }
    head += wide;
    if (control ? (n > kLongestControl || !last) : length_ + n > kLargest) return broken();
    if (end_ - begin_ < head + n) return Got::nothing;
    const std::string_view payload{in_.data() + begin_ + head, n};
    begin_ += head + n;
    if (control) {
      const Got got = take_control(opcode, payload);
      if (got != Got::nothing) return got;
      continue;
    }
    if (opcode > kBinary || (opcode == kContinuation) != partial_) return broken();
    std::memcpy(message_.data() + length_, payload.data(), n);
    length_ += n;
    partial_ = !last;
    if (last) return Got::message;
  }
  return Got::nothing;
}

WebSocket::Got WebSocket::take_control(unsigned opcode, std::string_view payload) noexcept {
  if (opcode == kPing) return send_frame(kPong, payload) ? Got::nothing : Got::broken;
  if (opcode == kPong) return Got::nothing;
  if (opcode == kClose) send_frame(kClose, payload.substr(0, 2));
  broken_ = true;
  return opcode == kClose ? Got::closed : Got::broken;
}

}  // namespace palpate::haply
