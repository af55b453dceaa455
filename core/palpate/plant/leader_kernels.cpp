#include "palpate/plant/leader_kernels.hpp"

#include "palpate/types/pack.hpp"

namespace palpate::plant {

PALPATE_AVX2_TOO void to_middle(double dt, const Lanes& q, const Lanes& v, const Lanes& v_before, Lanes& q_mid,
                                Lanes& v_mid) noexcept {
  store(load(q) + 0.5 * dt * load(v), q_mid);
  store(1.5 * load(v) - 0.5 * load(v_before), v_mid);
}

PALPATE_AVX2_TOO void sum_loads(const arm::LaneDynamics& d, const LeaderJoints& joints, double dt,
                                const Lanes& tau_drives, const Lanes& tau_elastic, const Lanes& q_mid, const Lanes& v,
                                LeaderLoads& loads, Six& V) noexcept {
  const Pack impulse = dt * load(joints.coulomb), q = load(q_mid), infinity = constant(__builtin_inf());
  store(load(tau_drives) - load(d.bias) - load(tau_elastic), loads.tau);
  store(where_at_most(q, load(joints.q_min), infinity, impulse), loads.hi);
  store(where_at_most(load(joints.q_max), q, -infinity, -impulse), loads.lo);
  for (int r = 0; r < 6; ++r) V[r] = dot(load(d.J[r]), load(v));
}

PALPATE_AVX2_TOO void assemble(const arm::LaneDynamics& d, const LeaderJoints& joints, double dt, const Six& H,
                               const Six& push, const Lanes& tau, const Lanes& v, Lanes (&A)[kLanes],
                               Lanes& b) noexcept {
  Pack of_motion = load(joints.rotor) * load(v), of_push = dt * load(tau);
  for (int j = 0; j < kLanes; ++j) of_motion = of_motion + v[j] * load(d.M[j]);
  for (int r = 0; r < 6; ++r) of_push = of_push + push[r] * load(d.J[r]);
  store(of_motion + of_push, b);
  Lanes HJ[6];
  for (int r = 0; r < 6; ++r) store(H[r] * load(d.J[r]), HJ[r]);
  for (int j = 0; j < kLanes; ++j) {
    Pack row = load(d.M[j]);
    for (int r = 0; r < 6; ++r) row = row + HJ[r][j] * load(d.J[r]);
    store(row, A[j]);
    A[j][j] += joints.rotor[j] + dt * joints.viscous[j];
  }
}

PALPATE_AVX2_TOO void change_of_velocity(const arm::LaneDynamics& d, const Lanes& v, const Lanes& v_next,
                                         Six& dV) noexcept {
  const Pack dv = load(v_next) - load(v);
  for (int r = 0; r < 6; ++r) dV[r] = dot(load(d.J[r]), dv);
}

PALPATE_AVX2_TOO void to_end(double dt, const LeaderJoints& joints, const Lanes& q_mid, const Lanes& v_next, Lanes& v,
                             Lanes& v_before, Lanes& q) noexcept {
  const Pack next = load(v_next);
  store(load(v), v_before);
  store(next, v);
  store(min(max(load(q_mid) + 0.5 * dt * next, load(joints.q_min)), load(joints.q_max)), q);
}

}  // namespace palpate::plant
