#include "palpate/stability/stability.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/so3.hpp"

namespace palpate::stability {
namespace {

constexpr double kMaxInput = 1e9;   // [N, N m] larger inputs are rejected, because their sums may overflow
constexpr double kRounding = 1e-9;  // [N, N m] smaller differences are rounding errors, not withheld wrenches

bool believable(const Wrench& F) noexcept {
  return (F.f.array().abs() < kMaxInput).all() && (F.t.array().abs() < kMaxInput).all();  // false for NaN
}

bool finite(const Wrench& F) noexcept { return F.f.allFinite() && F.t.allFinite(); }

/// The rendered wrench with its damping. The damping that the device renders is reduced by the same factor as the
/// force.
DampedWrench with_damping(const Wrench& rendered, const Wrench& commanded, const DampedWrench& asked,
                          const Vec3& v_LH) noexcept {
  const double size = commanded.f.squaredNorm();
  const double share = size > 0.0 ? std::clamp(rendered.f.dot(commanded.f) / size, 0.0, 1.0) : 1.0;
  DampedWrench out{rendered, asked.B};
  out.B *= std::isfinite(share) ? share : 0.0;
  out.F = rendered - out.damping(v_LH);
  return out;
}

}  // namespace

Stability::Stability(const Options& options, double dt)
    : dt_(dt),
      coupling_(options.coupling, dt),
      low_pass_(options.low_pass, dt),
      limiter_(options, dt),
      passivity_(options.passivity, options, low_pass_.lag(), dt) {}

Output Stability::step(const Input& in) noexcept {
  Output out;
  const Handle& handle = in.handle;
  const Wrench commanded = in.commanded.total(handle.V_LH.v);
  const double dt = in.dt > 0.0 ? in.dt : dt_;
  passivity_.observe(handle.X_LH, handle.V_LH, handle.q, in.potential, dt);
  Wrench smooth;
  if (!in.engaged || !believable(commanded)) {
    coupling_.reset();
    low_pass_.reset();
  } else {
    passivity_.credit(in.credit);
    passivity_.share(in.power * dt);
    const Wrench coupled = coupling_.step(commanded, in.stiffness);
    smooth = low_pass_.step(coupled);
    out.F_coupling = commanded - coupled;
    out.F_low_pass = coupled - smooth;
    out.lag = {coupling_.lag(in.stiffness), low_pass_.lag(), 0.0, 0.0};
  }
  if (!started_) X_LH_ = handle.X_LH;
  started_ = true;
  const Wrench& F = limiter_.now();
  const Vec3 dx = handle.X_LH.p - X_LH_.p, turn = rotation_vector(handle.X_LH.R * X_LH_.R.transpose());
  X_LH_ = handle.X_LH;
  // A wanted wrench that is not finite is passed on, so that the limiter reports it; the limiter takes it as zero.
  const Limited limited =
      limiter_.step({finite(commanded) ? smooth : commanded, in.t, in.handle, in.tool, in.engaged,
                     in.stiffness * dx.norm(), dt, in.present_potential, -F.f.dot(dx) - F.t.dot(turn), in.power * dt});
  out.F_capped = limited.F_H_L;
  out.F_cut = limited.F_cut;
  out.F_H_L = passivity_.step(out.F_capped);
  out.F_passivity = out.F_capped - out.F_H_L;
  out.on_hand = with_damping(out.F_H_L, commanded, in.commanded, handle.V_LH.v);
  out.status = limited.status;
  if (out.F_passivity.f.norm() + out.F_passivity.t.norm() > kRounding) out.status |= kPassivity;
  const double rate = limiter_.caps().rate_cap;
  out.lag.passivity = out.F_passivity.f.norm() / rate;
  out.lag.caps = out.F_cut.f.norm() / rate;
  return out;
}

void Stability::rendered(const Wrench& F_H_L) noexcept {
  limiter_.rendered(F_H_L);
  passivity_.rendered(F_H_L);
}

}  // namespace palpate::stability
