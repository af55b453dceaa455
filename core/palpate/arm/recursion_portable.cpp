// The recursion for every machine. Also chooses between the two builds, once.
#include "palpate/arm/recursion.hpp"

#define PALPATE_TARGET

namespace palpate::arm {
namespace portable {
#include "palpate/arm/recursion_body.inl"
}  // namespace portable

#if defined(__x86_64__)
namespace {
const bool kAvx2 = __builtin_cpu_supports("avx2") != 0;
}
#else
namespace {
constexpr bool kAvx2 = false;
}
#endif

void kinematics(const ChainLanes& c, const Lanes& q, ChainState& s) noexcept {
  kAvx2 ? avx2::chain_kinematics(c, q, s) : portable::chain_kinematics(c, q, s);
}
void dynamics(const ChainLanes& c, const Lanes& q, const Lanes& v, const Lanes& a, const TipBody& body,
              ChainState& s) noexcept {
  kAvx2 ? avx2::chain_dynamics(c, q, v, a, body, s) : portable::chain_dynamics(c, q, v, a, body, s);
}

}  // namespace palpate::arm

#undef PALPATE_TARGET
