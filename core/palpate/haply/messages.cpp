#include "palpate/haply/messages.hpp"

#include <boost/json/src.hpp>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <utility>

namespace palpate::haply {
namespace {

namespace json = boost::json;

const json::value* member(const json::value* at, std::string_view name) noexcept {
  const json::object* object = at == nullptr ? nullptr : at->if_object();
  return object == nullptr ? nullptr : object->if_contains(name);
}

bool is_text(const json::value* at, std::string_view text) noexcept {
  const json::string* found = at == nullptr ? nullptr : at->if_string();
  return found != nullptr && std::string_view(found->data(), found->size()) == text;
}

bool left_out(const json::value* at) noexcept { return at == nullptr || at->is_null(); }

/// A number without a fraction, from 0 on.
std::optional<std::uint64_t> whole_number(const json::value* at) noexcept {
  if (at == nullptr) return std::nullopt;
  if (at->is_uint64()) return at->get_uint64();
  if (at->is_int64() && at->get_int64() >= 0) return static_cast<std::uint64_t>(at->get_int64());
  return std::nullopt;
}

/// True or false, or 1 or 0; nothing for anything else.
std::optional<bool> truth(const json::value* at) noexcept {
  if (at == nullptr) return std::nullopt;
  if (at->is_bool()) return at->get_bool();
  const std::optional<std::uint64_t> n = whole_number(at);
  return n && *n <= 1 ? std::optional(*n == 1) : std::nullopt;
}

bool flag(const json::value* at, bool otherwise) noexcept { return truth(at).value_or(otherwise); }

/// Takes a flag that a message may leave out, and keeps the last one then; false if it is of another kind.
bool keep(const json::value* at, bool& last) noexcept {
  last = flag(at, last);
  return left_out(at) || truth(at).has_value();
}

/// True if this is the id of a device, as a text or as a number.
bool is_id(const json::value* at, std::string_view id) noexcept {
  const std::optional<std::uint64_t> n = whole_number(at);
  if (!n) return is_text(at, id);
  char digits[20];
  const char* end = std::to_chars(digits, digits + sizeof(digits), *n).ptr;
  return id == std::string_view(digits, static_cast<std::size_t>(end - digits));
}

/// A finite number; false, and `out` as it was, for anything else.
bool number(const json::value* at, double& out) noexcept {
  if (at == nullptr) return false;
  double x = 0.0;
  if (at->is_double()) {
    x = at->get_double();
  } else if (at->is_int64()) {
    x = static_cast<double>(at->get_int64());
  } else if (at->is_uint64()) {
    x = static_cast<double>(at->get_uint64());
  } else {
    return false;
  }
  if (!std::isfinite(x)) return false;
  out = x;
  return true;
}

template <std::size_t N>
bool numbers(const json::value* at, std::array<double, N>& out) noexcept {
  constexpr const char* kNames[] = {"x", "y", "z", "w"};
  for (std::size_t i = 0; i < N; ++i) {
    if (!number(member(at, kNames[i]), out[i])) return false;
  }
  return true;
}

/// The entry of a device in a list [{"device_id": id, ...}], or in the object {id: {...}} of service 3.0.
const json::value* entry(const json::value* list, std::string_view id) noexcept {
  if (list == nullptr) return nullptr;
  if (list->is_object()) return member(list, id);
  const json::array* entries = list->if_array();
  if (entries == nullptr) return nullptr;
  for (const json::value& one : *entries) {
    if (is_id(member(&one, "device_id"), id)) return &one;
  }
  return nullptr;
}

void read_grip(const json::value* grip, Measured& out) noexcept {
  const json::value* state = member(grip, "state");
  const json::value* buttons = member(state, "buttons");
  out.oriented = numbers(member(state, "orientation"), out.q);
  const auto pressed = [](const json::value* at) noexcept { return flag(at, false); };
  out.a = pressed(member(buttons, "a")) || pressed(member(buttons, "down")) || pressed(member(state, "button"));
  out.b = pressed(member(buttons, "b")) || pressed(member(buttons, "up"));
  out.c = pressed(member(buttons, "c")) || pressed(member(buttons, "right"));
  out.awake = flag(member(member(grip, "status"), "awake"), true);
  number(member(state, "battery_level"), out.battery);
}

}  // namespace

Reader::Reader(std::string device, std::string grip, std::string list)
    : device_(std::move(device)),
      grip_(std::move(grip)),
      list_(std::move(list)),
      values_(new unsigned char[kValues]),
      stack_(new unsigned char[kStack]),
      memory_(values_.get(), kValues),
      parser_(json::storage_ptr(&memory_), json::parse_options{}, stack_.get(), kStack) {}

json::value Reader::parse(std::string_view text) noexcept {
  memory_.release();
  parser_.reset(&memory_);
  boost::system::error_code error;
  try {
    parser_.write(text.data(), text.size(), error);
    if (error) return json::value(&memory_);
    return parser_.release();
  } catch (...) {  // not reached: the buffers are large enough
    return json::value(&memory_);
  }
}

Parsed Reader::read(std::string_view text, Measured& out) noexcept {
  const json::value whole = parse(text);
  const json::value* devices = member(&whole, "inverse3");
  if (devices == nullptr || !(devices->is_array() || devices->is_object())) return Parsed::malformed;
  const json::value* device = entry(devices, device_);
  if (device == nullptr) return Parsed::gone;
  out = {};
  const json::value *state = member(device, "state"), *status = member(device, "status");
  if (!numbers(member(state, "cursor_position"), out.p)) return Parsed::malformed;
  out.moving = !left_out(member(state, "cursor_velocity"));
  if (out.moving && !numbers(member(state, "cursor_velocity"), out.v)) return Parsed::malformed;
  if (!left_out(status) && !status->is_object()) return Parsed::malformed;
  if (!keep(member(status, "calibrated"), calibrated_) || !keep(member(status, "ready"), ready_)) {
    return Parsed::malformed;
  }
  out.calibrated = calibrated_;
  out.ready = ready_;
  if (!grip_.empty()) read_grip(entry(member(&whole, list_), grip_), out);
  return Parsed::good;
}

Event Reader::read_event(std::string_view text) noexcept {
  const json::value whole = parse(text);
  const json::value *name = member(&whole, "name"), *data = member(&whole, "data");
  if (is_text(name, "invalid-value")) return Event::invalid;
  const json::value* id = member(data, "device_id");
  const bool ours = is_id(id, device_), grip = !grip_.empty() && is_id(id, grip_);
  if (is_text(name, "device-sleep")) return grip ? Event::sleep : Event::none;
  if (is_text(name, "device-battery-low") || is_text(name, "device-battery-critical")) {
    return grip ? Event::battery : Event::none;
  }
  if (!ours) return Event::none;
  if (is_text(name, "device-disconnected")) return Event::disconnected;
  if (!is_text(name, "device-safety-triggered")) return Event::none;
  const json::value* kind = member(data, "safety_type");
  if (is_text(kind, "ebrake_triggered")) return Event::ebrake;
  if (is_text(kind, "ebrake_released")) return Event::ebrake_released;
  return is_text(kind, "stall_detected") ? Event::stall : Event::other;
}

ForceMessage::ForceMessage(const std::string& id, bool vector) {
  const std::string head = R"({"inverse3":[{"device_id":)" + id + R"(,"commands":{"set_cursor_force":{")" +
                           (vector ? "vector" : "values") + R"(":{"x":)";
  if (head.size() > text_.size() - 256) throw std::invalid_argument("the id of the device is too long");
  std::memcpy(text_.data(), head.data(), head.size());
  head_ = head.size();
}

std::string_view ForceMessage::text(double x, double y, double z) noexcept {
  char* at = text_.data() + head_;
  const auto put = [&at](std::string_view words) {
    std::memcpy(at, words.data(), words.size());
    at += words.size();
  };
  const auto write = [&at](double value) {
    const double within = std::isfinite(value) && std::abs(value) < 1e3 ? value : 0.0;
    at = std::to_chars(at, at + 32, within, std::chars_format::fixed, 6).ptr;
  };
  write(x);
  put(R"(,"y":)");
  write(y);
  put(R"(,"z":)");
  write(z);
  put("}}}}]}");
  return {text_.data(), static_cast<std::size_t>(at - text_.data())};
}

}  // namespace palpate::haply
