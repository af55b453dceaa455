#include "palpate/network/playout.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::network {
namespace {

/// Cubic between two packets that matches positions and velocities; u in 0..1 is the place between them.
void between(const Datagram& a, const Datagram& b, double u, Played& out) noexcept {
  const double T = b.t - a.t, u2 = u * u, u3 = u2 * u;
  const Vec3 pa = a.X.p, pb = b.X.p, va = T * a.v, vb = T * b.v;
  out.X.p = (2 * u3 - 3 * u2 + 1) * pa + (u3 - 2 * u2 + u) * va + (3 * u2 - 2 * u3) * pb + (u3 - u2) * vb;
  out.v = ((6 * u2 - 6 * u) * (pa - pb) + (3 * u2 - 4 * u + 1) * va + (3 * u2 - 2 * u) * vb) / T;
  const Eigen::Quaterniond qa(a.X.R), qb(b.X.R);
  out.X.R = qa.slerp(u, qb).toRotationMatrix();
  out.flags = a.flags;
  out.jaw = (1.0 - u) * a.jaw + u * b.jaw;
}

}  // namespace

void Playout::add(const Datagram& d) noexcept {
  std::size_t i = 0;
  while (i < size_ && at(i).t > d.t) ++i;
  if ((i < size_ && at(i).t == d.t) || i >= kSize - 1) return;
  head_ = (head_ + 1) % kSize;
  size_ = std::min(size_ + 1, kSize);
  for (std::size_t k = 0; k < i; ++k) at(k) = at(k + 1);
  at(i) = d;
}

Played Playout::step(double now, double wanted, double dt) noexcept {
  if (delay_ < 0.0 || std::abs(wanted - delay_) > kJump) delay_ = wanted;
  delay_ += std::clamp(wanted - delay_, -kShrink * dt, kStretch * dt);
  const double t = now - delay_;
  Played out;
  out.stamp = t;
  if (size_ == 0) {
    out.late = true;
    return out;
  }
  std::size_t i = 0, end = size_ - 1;  // the newest packet that is no newer than t, or the oldest one
  while (i < end) {
    const std::size_t middle = (i + end) / 2;
    if (at(middle).t > t) {
      i = middle + 1;
    } else {
      end = middle;
    }
  }
  if (i == 0 || at(i).t > t) {  // nothing is newer than t, or t lies before the buffer
    out.X = at(i).X;
    out.jaw = at(i).jaw;
    out.flags = at(i).flags;
    out.late = i == 0;
    out.stamp = std::min(t, at(i).t);
    return out;
  }
  between(at(i), at(i - 1), (t - at(i).t) / (at(i - 1).t - at(i).t), out);
  return out;
}

}  // namespace palpate::network
