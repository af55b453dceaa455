#include "palpate/mapping/recentring.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/require.hpp"

namespace palpate::mapping {
namespace {

constexpr double kRest = 0.005;     // [m/s] speed of the tool below which it does not drift: noise of a resting hand
constexpr double kStartTime = 0.1;  // [s] time in which rate control reaches its largest speed
constexpr double kNoForce = 1e-9;   // [N, m] smaller forces and corrections count as none

/// v without its part against a.
Vec3 not_against(const Vec3& v, const Vec3& a) noexcept {
  const double along = a.dot(v);
  return along < 0.0 && a.squaredNorm() > kNoForce * kNoForce ? Vec3(v - along / a.squaredNorm() * a) : v;
}

}  // namespace

Recentring::Recentring(const RecentringOptions& options) : options_(options) {
  if (options.law == Law::position) return;
  for (int i = 0; i < 3; ++i) {
    require("mapping", options.workspace[i] > 0.0 && options.workspace[i] <= 10.0, "workspace", options.workspace[i],
            "each length must be above 0 and at most 10 m, for example 0.16");
  }
  require("mapping", !options.centre || options.centre->allFinite(), "centre", options.centre ? options.centre->x() : 0,
          "must be a position in m");
  require("mapping", options.rim >= 0.0 && options.rim < 1.0, "rim", options.rim, "must be 0 to below 1");
  require("mapping", options.rim_speed > 0.0 && options.rim_speed <= 1.0, "rim_speed", options.rim_speed,
          "must be above 0 and at most 1 m/s, for example 0.05");
  require("mapping", options.drift > 0.0 && options.drift < 1.0, "drift", options.drift,
          "must be above 0 and below 1, for example 0.2");
}

Vec3 Recentring::step(const RecentringInput& in, double dt) noexcept {
  if (options_.law == Law::position) return Vec3::Zero();
  if (!started_) p_LC_ = options_.centre.value_or(in.p_LH);
  started_ = true;
  Vec3 v = not_against(not_against(wanted(in, dt), in.F_T_W), in.correction_W);
  const bool loads = in.F_T_W.dot(v) < 0.0;  // along the fixture, against the force
  v_ = in.reached && !loads && v.allFinite() ? v : Vec3::Zero();
  released_ = in.F_T_W.dot(v_) * dt;
  return v_ * dt;
}

// Velocity before its part against forces is removed, in W.
Vec3 Recentring::wanted(const RecentringInput& in, double dt) const noexcept {
  const Vec3 p = in.p_LH - p_LC_;
  const double u = p.cwiseQuotient(0.5 * options_.workspace).norm();
  const Vec3 e = in.R_WL * p.stableNormalized();
  if (options_.law == Law::drift) return options_.drift * std::min(u, 1.0) * std::max(in.speed - kRest, 0.0) * e;
  const double s = std::clamp((u - options_.rim) / (1.0 - options_.rim), 0.0, 1.0);
  const Vec3 change = options_.rim_speed * s * s * e - v_;
  const double most = options_.rim_speed / kStartTime * dt;
  return v_ + change * std::min(1.0, most / std::max(change.norm(), 1e-12));
}

}  // namespace palpate::mapping
