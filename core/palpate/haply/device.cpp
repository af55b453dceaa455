#include "palpate/haply/device.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/loop/realtime.hpp"

namespace palpate::haply {
namespace {

using loop::Reading;

constexpr double kOpen = 0.5;        // [rad] angle of the gripper while its button is released, as for a mouse
constexpr double kLowBattery = 0.1;  // [-]
constexpr int kMostAnswers = 8;      // messages that one tick takes
constexpr int kMostEvents = 8;       // events that one tick takes: a flood of them must not hold the thread
constexpr const char* kNotices[] = {
    "the service did not answer in time, and the force was zero meanwhile; mend: give the service its own core, or a "
    "lower rate, e.g. ",
    "an answer of the service was no valid state, and the force was zero meanwhile; mend: update the service",
    "the device says that it is not calibrated, and gets no force: its positions may be mirrored; mend: calibrate it "
    "in Haply Hub",
    "the device was not ready and got no force; mend: look at its light and its power supply",
    "the grip fell asleep: its orientation stands still until somebody moves it",
    "the battery of the grip is nearly empty; mend: charge it",
    "the emergency brake locked the device, which got no force; mend: let go of it and release the brake",
    "a motor stalled, and the force was dropped; mend: press less, or lower stability.force_cap",
    "the service reported a safety event, and the force was dropped; mend: look at Haply Hub",
    "the service refused a value; mend: update the service, and report this",
    "the grip vanished from the messages: its orientation stands still",
    "the device vanished from the messages; mend: look at its cable and its power",
};

Mat3 rotation(const std::array<double, 4>& q) noexcept {
  return Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix();
}

}  // namespace

Device::Device(Options options, std::shared_ptr<WebSocket> service, std::shared_ptr<WebSocket> events)
    : options_(std::move(options)),
      service_(std::move(service)),
      events_(std::move(events)),
      reader_(options_.device, options_.grip, options_.list),
      command_(options_.address, options_.vector),
      valid_(loop::now_ns()) {
  info_.abi = PALPATE_DRIVER_ABI;
  const std::string name = "Haply " + options_.device;
  name.copy(info_.name, sizeof(info_.name) - 1);
  info_.rate = options_.rate;
  info_.force_max = options_.force_max;
  std::fill_n(info_.workspace, 3, options_.workspace);
}

Device::~Device() { Device::write({}); }

Reading Device::read(loop::DeviceState& state) noexcept {
  take_events();
  if (failure_ != none) return Reading::failed;
  if (exchanges_ == 0 && unanswered_ == 0) {  // the first message: the session may begin long after the connection
    valid_ = loop::now_ns();
    Device::write({});
  }
  const Reading found = take_answer(state);
  if (found == Reading::failed) return found;
  const bool dropped = std::exchange(dropped_, false) || locked_;
  return dropped ? Reading::missing : found;
}

Reading Device::take_answer(loop::DeviceState& state) noexcept {
  const std::int64_t end = loop::now_ns() + (waiting_ ? 0 : kSilent);
  while (unanswered_ > 0) {
    switch (receive_answer(end)) {
      case WebSocket::Got::message:
        exchanges_.fetch_add(1, std::memory_order_relaxed);
        unanswered_.fetch_sub(1);
        break;
      case WebSocket::Got::nothing:
        waiting_ = true;
        note(silent);
        return loop::now_ns() - valid_ > kGone ? fail(never) : Reading::missing;
      case WebSocket::Got::closed:
        return fail(closed);
      case WebSocket::Got::broken:
        return fail(broken);
    }
  }
  waiting_ = false;
  Measured found;
  Parsed parsed = Parsed::malformed;
  WebSocket::Got more = WebSocket::Got::message;
  for (int taken = 0; more == WebSocket::Got::message && taken < kMostAnswers; ++taken) {
    parsed = reader_.read(service_->message(), found);
    more = service_->receive(0);  // a message that nobody asked for: the newest state counts, else all would be late
    if (more == WebSocket::Got::message && unanswered_ > 0) unanswered_.fetch_sub(1);
  }
  if (more == WebSocket::Got::closed || more == WebSocket::Got::broken) {
    return fail(more == WebSocket::Got::closed ? closed : broken);
  }
  switch (parsed) {
    case Parsed::good:
      return judge(found, state);
    case Parsed::gone:
      note(vanished);
      if (vanished_ == 0) vanished_ = loop::now_ns();
      return loop::now_ns() - vanished_ > kUnplugged ? fail(gone) : Reading::missing;
    case Parsed::malformed:
      vanished_ = 0;
      note(malformed);
  }
  return loop::now_ns() - valid_ > kGone ? fail(never) : Reading::missing;
}

// The next answer, waited for until a time [ns]; counts the first answer that was not there yet.
WebSocket::Got Device::receive_answer(std::int64_t end) noexcept {
  const WebSocket::Got there = service_->receive(0);
  if (there != WebSocket::Got::nothing || waiting_) return there;
  late_.fetch_add(1, std::memory_order_relaxed);
  return service_->receive(std::max<std::int64_t>(0, end - loop::now_ns()));
}

// The state of the device, or that there is no force although there is a state.
Reading Device::judge(const Measured& found, loop::DeviceState& state) noexcept {
  valid_ = loop::now_ns();
  vanished_ = 0;
  if (!found.calibrated) note(uncalibrated);
  if (!found.ready) note(unready);
  if (!options_.grip.empty()) {
    if (!found.oriented) note(grip_lost);
    if (!found.awake) note(asleep);
    if (found.battery < kLowBattery) note(battery_low);
    const double norm = std::hypot(std::hypot(found.q[0], found.q[1]), std::hypot(found.q[2], found.q[3]));
    if (found.oriented && std::abs(norm - 1.0) < 0.05) q_ = found.q;
  }
  const Mat3 R = rotation(q_);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) state.X_LH[4 * i + j] = R(static_cast<int>(i), static_cast<int>(j));
    state.X_LH[4 * i + 3] = found.p[i];
    state.X_LH[12 + i] = 0.0;
  }
  state.X_LH[15] = 1.0;
  state.V_LH.reset();
  if (options_.grip.empty() && found.moving) state.V_LH = {found.v[0], found.v[1], found.v[2], 0.0, 0.0, 0.0};
  state.clutch = found.a;
  state.buttons = (found.a ? PALPATE_BUTTON_CLUTCH | PALPATE_BUTTON_OWN(0) : 0u) |
                  (found.b ? PALPATE_BUTTON_OWN(1) : 0u) | (found.c ? PALPATE_BUTTON_COAG | PALPATE_BUTTON_OWN(2) : 0u);
  state.gripper = found.b ? 0.0 : kOpen;
  return found.calibrated && found.ready ? Reading::measured : Reading::missing;
}

void Device::take_events() noexcept {
  for (int taken = 0; taken < kMostEvents && events_; ++taken) {
    if (events_->receive(0) != WebSocket::Got::message) return;
    const Event event = reader_.read_event(events_->message());
    if (event == Event::sleep) note(asleep);
    if (event == Event::battery) note(battery_low);
    if (event == Event::invalid) note(invalid);
    if (event == Event::ebrake || event == Event::ebrake_released) locked_ = event == Event::ebrake;
    if (event == Event::ebrake) note(ebrake);
    if (event == Event::stall) note(stalled);
    if (event == Event::other) note(other_event);
    dropped_ = dropped_ || event == Event::ebrake || event == Event::stall || event == Event::other;
    if (event == Event::disconnected) fail(gone);
  }
}

bool Device::write(const Wrench& F) noexcept {
  const bool zero = F.f.isZero(0.0);
  if (writing_.test_and_set(std::memory_order_acquire)) return true;  // the other thread commands zero at this moment
  bool sent = true;
  if (unanswered_ == 0 || (zero && !zero_)) {
    unanswered_.fetch_add(1);
    sent = service_->send(command_.text(F.f.x(), F.f.y(), F.f.z()));
    zero_ = zero;
  }
  writing_.clear(std::memory_order_release);
  if (!sent && failure_ == none) failure_ = broken;
  return sent;
}

Reading Device::fail(Failure why) noexcept {
  int none_yet = none;
  failure_.compare_exchange_strong(none_yet, why);
  return Reading::failed;
}

std::string Device::why() const {
  switch (failure_) {
    case closed:
      return "the service closed the connection";
    case broken:
      return "the connection to the service is broken: it ended, or sent what is no WebSocket message of at most 64 kB";
    case gone:
      return "device " + options_.device + " vanished: its cable or its power";
    case never:
      return "the service gave no valid state for 1 s: it hangs, or speaks a version that is not known";
    default:
      return "";
  }
}

std::vector<std::string> Device::notices() const {
  std::vector<std::string> out;
  const unsigned noted = noted_;
  for (unsigned i = 0; i < std::size(kNotices); ++i) {
    if ((noted >> i & 1u) == 0) continue;
    out.emplace_back(kNotices[i]);
    if (i == silent) out.back() += "haply:rate=" + std::to_string(std::lround(0.5 * options_.rate));
  }
  return out;
}

}  // namespace palpate::haply
