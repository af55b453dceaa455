#include "palpate/loop/device_cycle.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/loop/realtime.hpp"
#include "palpate/types/so3.hpp"
#include "palpate/types/status.hpp"

namespace palpate::loop {
namespace {

constexpr double kLargest = 1e6;       // larger numbers count as not finite
constexpr double kReach = 100.0;       // [m] and larger distances
constexpr double kRigid = 1e-3;        // [-] accepted error of a rotation matrix, enough for single precision
constexpr double kHour = 3600.0;       // [s] a longer gap counts as a clock that was set
constexpr double kWall0 = 1.0;         // [s] stamp at the start: a stamp of zero would be invalid
constexpr double kRateShare = 0.02;    // weight of a new period in the running mean
constexpr std::uint64_t kKnown = 100;  // steps after which the mean period is judged
constexpr double kLargestRatio = 2.5;  // rate of the steps over the rate of the cycle

using RowMajor4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

DeviceFault check_pose(const RowMajor4& X) noexcept {
  if (!(X.array().abs() < kLargest).all()) return DeviceFault::not_finite;  // false for NaN
  if (!(X.topRightCorner<3, 1>().array().abs() < kReach).all()) return DeviceFault::not_finite;
  const Mat3 R = X.topLeftCorner<3, 3>();
  const bool orthonormal = ((R * R.transpose()) - Mat3::Identity()).cwiseAbs().maxCoeff() < kRigid;
  const bool affine = (X.row(3) - Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)).cwiseAbs().maxCoeff() < kRigid;
  if (!orthonormal || !affine) return DeviceFault::not_rigid;
  return R.determinant() > 0.0 ? DeviceFault::none : DeviceFault::left_handed;
}

DeviceFault check_numbers(const DeviceState& state) noexcept {
  const auto fine = [](double x) { return std::abs(x) < kLargest; };
  if (state.V_LH && !std::all_of(state.V_LH->begin(), state.V_LH->end(), fine)) return DeviceFault::not_finite;
  if (!(std::abs(state.gripper) < 10.0)) return DeviceFault::not_finite;
  return check_pose(Eigen::Map<const RowMajor4>(state.X_LH.data()));
}

unsigned status_bits(DeviceFault fault) noexcept {
  switch (fault) {
    case DeviceFault::none:
    case DeviceFault::gap:  // the cycle finds this by itself: kStalled
      return kOk;
    case DeviceFault::time_not_increasing:
      return kBadStamp;
    case DeviceFault::too_often:
      return kSlow;
    case DeviceFault::driver_failed:
      return kLeaderStale;
    default:
      return kNotFinite;
  }
}

CrtkOptions for_device(CrtkOptions o) {
  o.own_teleop = o.virtual_follower = true;
  o.needs_operator = o.needs_state = o.tip_frame = false;
  return o;
}

}  // namespace

DeviceState Glide::at(int k) const noexcept {
  const End now = from + (static_cast<double>(k) / steps) * (to - from);
  RowMajor4 X = RowMajor4::Identity();
  X.topLeftCorner<3, 3>() = rotation_by(now.segment<3>(3));
  X.topRightCorner<3, 1>() = now.head<3>();
  DeviceState state{.t = t + k * dt, .gripper = now[6]};
  Eigen::Map<RowMajor4>(state.X_LH.data()) = X;
  return state;
}

DeviceCycle::DeviceCycle(CrtkOptions options, arm::Arm follower, std::shared_ptr<const scene::Snapshot> scene)
    : cycle_(for_device(std::move(options)), std::move(follower)),
      front_(cycle_.contact(), std::move(scene), cycle_.options().rate, cycle_.options().guidance) {
  gates_.following = gates_.operator_present = gates_.leader_enabled = gates_.follower_enabled = true;
  cycle_.set_scene(front_.scene());
  front_.collide();
}

void DeviceCycle::start() {
  front_.open();
  front_.start_threads(cycle_.options().contact.collision_rate);
}

void DeviceCycle::stop() { front_.stop_threads(); }

const Wrench& DeviceCycle::step(const DeviceState& state) noexcept {
  const DeviceFault time = check_time(state.t);
  const DeviceFault numbers = check_numbers(state);
  fault_ = numbers != DeviceFault::none ? numbers : time;
  take();
  if (numbers == DeviceFault::none) {
    feed(state);
  } else {
    cycle_.reset_wrench();
  }
  return advance();
}

const Wrench& DeviceCycle::report_failure() noexcept {
  const double period = 1.0 / cycle_.options().rate;
  fault_ = DeviceFault::driver_failed;
  clock_ += period;
  ahead_ += period;
  take();
  cycle_.reset_wrench();
  return advance();
}

// Advances the clock of the cycle. It follows the time of the caller, but never goes back or stands still.
DeviceFault DeviceCycle::check_time(double t) noexcept {
  const double period = 1.0 / cycle_.options().rate, passed = t - t_;
  const bool first = steps_ == 0;
  if (std::isfinite(t)) t_ = t;
  if (first && std::isfinite(t)) return DeviceFault::none;
  if (!(passed > 0.0 && passed < kHour)) {
    clock_ += period;
    return std::isfinite(t) ? DeviceFault::time_not_increasing : DeviceFault::not_finite;
  }
  const double advance = std::max(passed - ahead_, 0.5 * period);  // never back: later steps catch up with the rest
  ahead_ += advance - passed;
  clock_ += advance;
  period_ += (steps_ == 1 ? 1.0 : kRateShare) * (std::min(passed, 1.0) - period_);
  if (passed > cycle_.options().watch.stale_after) return DeviceFault::gap;
  return steps_ > kKnown && period_ * kLargestRatio < period ? DeviceFault::too_often : DeviceFault::none;
}

// Takes the controls, scene and fixtures that other threads have set since the last step.
void DeviceCycle::take() noexcept {
  Controls controls = front_.take_controls();
  const bool other = front_.take_scene(clock_);
  cycle_.set_scene(front_.scene());
  reach_out(controls);
  cycle_.set_controls(controls);
  if (other) cycle_.forget_contacts();
  if (front_.take_fixtures()) cycle_.take(front_.fixtures());
}

// Takes objects and force from the other end of a link; without a link the tool holds.
void DeviceCycle::reach_out(Controls& controls) noexcept {
  if (!link_.attached()) return;
  const RemoteTick* felt = link_.step(clock_);
  controls.hold_all |= felt == nullptr || !felt->linked;
  cycle_.push(felt == nullptr ? Vec3(Vec3::Zero()) : felt->F);
  if (felt != nullptr && felt->scene != nullptr) cycle_.set_scene(*felt->scene);
}

void DeviceCycle::feed(const DeviceState& state) noexcept {
  const RowMajor4 X = Eigen::Map<const RowMajor4>(state.X_LH.data());
  const Eigen::Quaterniond turn = Eigen::Quaterniond(Mat3(X.topLeftCorner<3, 3>())).normalized();
  const double stamp = kWall0 + clock_;
  const ClockTime now{clock_, stamp};
  if (state.V_LH) {
    const std::array<double, 6>& V = *state.V_LH;
    cycle_.leader_twist(stamp, {{V[0], V[1], V[2]}, {V[3], V[4], V[5]}}, now);
  }
  cycle_.gripper(stamp, &state.gripper, 1);
  cycle_.leader_pose(stamp, X.topRightCorner<3, 1>(), turn.coeffs(), now);
  clutch_ = state.clutch;
}

const Wrench& DeviceCycle::advance() noexcept {
  const std::int64_t begin = now_ns();
  gates_.clutch = clutch_;
  cycle_.set_gates(gates_);
  cycle_.report(status_bits(fault_));
  const CrtkOutput& out = cycle_.step({clock_, kWall0 + clock_});
  F_ = out.command ? out.F : Wrench{};
  tau_gripper_ = out.command ? out.tau_gripper : 0.0;
  const std::int64_t spent = now_ns() - begin;
  cycle_time_.add(spent);
  Tick tick = out.tick;
  tick.cycle_us = 1e-3 * static_cast<double>(spent);
  if (link_.attached()) link_.remember(tick, cycle_.mapping().energy_ratio());
  status_ = static_cast<std::uint64_t>(tick.status);
  front_.record(tick);
  front_.keep(tick);
  front_.show(tick);
  ++steps_;
  return F_;
}

void glide(std::span<const std::shared_ptr<DeviceCycle>> cycles, std::span<const Glide> paths, Bodies* bodies,
           std::span<double> felt) noexcept {
  std::fill(felt.begin(), felt.end(), 0.0);
  for (int k = 1; k <= paths.front().steps; ++k) {
    for (std::size_t i = 0; i < cycles.size(); ++i) {
      felt[i] = std::max(felt[i], cycles[i]->step(paths[i].at(k)).f.norm());
    }
    if (bodies != nullptr) bodies->advance(paths.front().dt);
  }
}

}  // namespace palpate::loop
