#include "palpate/stability/saturation.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::stability {

double Saturation::step(const Input& in, double cap) noexcept {
  const double U = in.potential, wanted = in.force > cap ? cap / in.force : 1.0;
  if (!std::isfinite(U) || !(U > 0.0)) {
    reset();
    return 1.0;
  }
  if (!acts_ && wanted == 1.0) return 1.0;
  const auto left = [U](double s) { return U * (1.0 - (1.0 - s) * (1.0 - s)); };  // S for s = sqrt(E / U)
  if (!acts_) left_ = left(wanted), energy_ = wanted * wanted * U;
  acts_ = true;
  if (U <= energy_) {  // S = U for every E >= U
    if (wanted == 1.0) {
      reset();
      return 1.0;
    }
    energy_ = U;
  }
  const double lasting = std::min(std::sqrt(energy_ / U), wanted);
  const double most = left_ + surplus_ + in.work + share_ * in.work_of_motion;
  share_ = most > left(wanted) ? wanted : std::max(1.0 - std::sqrt(std::max(1.0 - most / U, 0.0)), lasting);
  left_ = left(share_);
  surplus_ = most - left_;
  energy_ = share_ * share_ * U;
  return share_;
}

}  // namespace palpate::stability
