// The client's end of a WebSocket (RFC 6455) on a connected socket, whose handshake is done.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string_view>

namespace palpate::haply {

/// After the construction nothing allocates, blocks or throws, but receive() waits as long as it is told to. One thread
/// receives; send() may be called from two.
class WebSocket {
 public:
  static constexpr std::size_t kLargest = 1u << 16;  ///< bytes of a message; a longer one breaks the connection

  /// Result of receive().
  enum class Got : int {
    message,  ///< a whole message: see message()
    nothing,  ///< no message within the time
    closed,   ///< the peer has closed the connection
    broken,   ///< what the peer sent is no WebSocket, or the connection is lost
  };

  /// Takes over a connected socket.
  explicit WebSocket(int socket);
  /// Says good-bye and closes the socket.
  ~WebSocket();
  WebSocket(const WebSocket&) = delete;
  WebSocket& operator=(const WebSocket&) = delete;

  /// Sends a text of up to kLargest bytes, at once or not at all. Returns false if the connection is broken.
  bool send(std::string_view text) noexcept;
  /// Waits for a message, at most timeout [ns].
  Got receive(std::int64_t timeout) noexcept;
  /// The newest message, until the next receive().
  [[nodiscard]] std::string_view message() const noexcept { return {message_.data(), length_}; }

 private:
  using Bytes = std::array<char, kLargest>;

  bool send_frame(unsigned opcode, std::string_view payload) noexcept;
  Got take_frame() noexcept;
  Got take_control(unsigned opcode, std::string_view payload) noexcept;
  Got wait(std::int64_t timeout) noexcept;

  int socket_;
  std::atomic<bool> broken_{false};
  std::atomic_flag sending_ = ATOMIC_FLAG_INIT;
  std::uint32_t mask_;
  std::array<char, 2 * kLargest> in_{};  ///< received bytes that are not used yet: [begin_, end_)
  std::size_t begin_ = 0, end_ = 0;
  Bytes message_{};         ///< payloads of the frames of the present message
  std::size_t length_ = 0;  ///< its length so far [bytes]
  bool partial_ = false;    ///< more frames of the message follow
  std::array<char, kLargest + 14> out_{};
};

}  // namespace palpate::haply
