// The recursion for every machine. Also chooses between the three builds, once.
#include "palpate/arm/recursion.hpp"

#define PALPATE_TARGET

namespace palpate::arm {
namespace portable {
#include "palpate/arm/recursion_body.inl"
}  // namespace portable

namespace {

#if defined(__x86_64__)
const bool kAvx2 = __builtin_cpu_supports("avx2") != 0;
const bool kAvx512 = __builtin_cpu_supports("avx512vl") != 0 && __builtin_cpu_supports("avx512dq") != 0;
#else
constexpr bool kAvx2 = false, kAvx512 = false;
#endif
const auto chain_kinematics = kAvx512 ? avx512::chain_kinematics
                              : kAvx2 ? avx2::chain_kinematics
                                      : portable::chain_kinematics;
const auto chain_dynamics = kAvx512 ? avx512::chain_dynamics : kAvx2 ? avx2::chain_dynamics : portable::chain_dynamics;

}  // namespace

void kinematics(const ChainLanes& c, const Lanes& q, ChainState& s) noexcept { chain_kinematics(c, q, s); }
void dynamics(const ChainLanes& c, const Lanes& q, const Lanes& v, const Lanes& a, const TipBody& body,
              ChainState& s) noexcept {
  chain_dynamics(c, q, v, a, body, s);
}

}  // namespace palpate::arm

#undef PALPATE_TARGET
