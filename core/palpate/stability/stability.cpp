#include "palpate/stability/stability.hpp"


namespace palpate::stability {
namespace {

constexpr double kHuge = 1e9;     // [N, N m] beyond it no number is believed: sums of such forces may be infinite
constexpr double kSliver = 1e-9;  // [N, N m] less than that was not withheld, but rounded

bool believable(const Wrench& F) noexcept {
  return (F.f.array().abs() < kHuge).all() && (F.t.array().abs() < kHuge).all();  // so written, NaN is not
}

bool finite(const Wrench& F) noexcept { return F.f.allFinite() && F.t.allFinite(); }

}  // namespace

Stability::Stability(const Options& options, double dt)
    : coupling_(options.coupling, dt),
      low_pass_(options.low_pass, dt),
      passivity_(options.passivity, options, dt),
      limiter_(options, dt) {}

Output Stability::step(const Input& in) noexcept {
  Output out;
  passivity_.observe(in.X_LH, in.V_LH, in.q);
  if (!in.engaged || !believable(in.F_H_L)) {
    coupling_.reset();
    low_pass_.reset();
    if (!in.engaged) passivity_.forgive();
    out.F_capped = passivity_.step({}, limiter_);
  } else {
    passivity_.lend(in.lent);
    const Wrench coupled = coupling_.step(in.F_H_L, in.stiffness);
    const Wrench smooth = low_pass_.step(coupled);
    out.F_capped = passivity_.step(smooth, limiter_);
    out.F_coupling = in.F_H_L - coupled;
    out.F_low_pass = coupled - smooth;
    out.F_passivity = smooth - out.F_capped;
    out.lag = {coupling_.lag(in.stiffness), low_pass_.lag(), 0.0, 0.0};
  }
  Wanted last = in;
  if (finite(in.F_H_L)) last.F_H_L = out.F_capped;  // otherwise the limiter says so, and asks for zero
  const Limited limited = limiter_.step(last);
  out.F_H_L = limited.F_H_L;
  out.status = limited.status;
  if (out.F_passivity.f.norm() + out.F_passivity.t.norm() > kSliver) out.status |= kPassivity;
  const double rate = limiter_.caps().rate_cap;
  out.lag.passivity = out.F_passivity.f.norm() / rate;
  out.lag.caps = (out.F_capped - out.F_H_L).f.norm() / rate;
  return out;
}

void Stability::rendered(const Wrench& F_H_L) noexcept {
  limiter_.rendered(F_H_L);
  passivity_.rendered(F_H_L);
}

}  // namespace palpate::stability
