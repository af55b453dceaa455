#include "palpate/plant/leader_kernels.hpp"

#include <cstddef>

#include "palpate/types/arc_sine.hpp"
#include "palpate/types/pack.hpp"

namespace palpate::plant {
namespace {

/// J v, the velocity of the handle.
PALPATE_INLINE Pack handle_velocity(const arm::LaneDynamics& d, const Pack& v) noexcept {
  Four part[8] = {};
  for (int r = 0; r < 6; ++r) {
    const Pack row = load(d.J[r]);
    part[r < 3 ? r : r + 1] = row.low * v.low + row.high * v.high;
  }
  Four sums[2];
  for (std::size_t i = 0; i < 2; ++i) {
    const Four *p = part + 4 * i, ab = __builtin_shufflevector(p[0], p[1], 0, 4, 2, 6), cd = p[2];
    const Four even = ab + __builtin_shufflevector(p[0], p[1], 1, 5, 3, 7);
    const Four odd = __builtin_shufflevector(cd, p[3], 0, 4, 2, 6) + __builtin_shufflevector(cd, p[3], 1, 5, 3, 7);
    sums[i] = __builtin_shufflevector(even, odd, 0, 1, 4, 5) + __builtin_shufflevector(even, odd, 2, 3, 6, 7);
  }
  return {sums[0], sums[1]};
}

/// Force of the hand's spring and damper.
PALPATE_INLINE Pack spring_and_damper(const HandLanes& hand, const Pack& error, const double (&v)[3],
                                      const double (&w)[3]) noexcept {
  const Pack V_path = {Four{v[0], v[1], v[2], 0.0}, Four{w[0], w[1], w[2], 0.0}};
  return load(hand.K) * error + load(hand.B) * V_path;
}

}  // namespace

PALPATE_AVX2_TOO void to_middle(double dt, const Lanes& q, const Lanes& v, const Lanes& v_before, Lanes& q_mid,
                                Lanes& v_mid) noexcept {
  store(load(q) + 0.5 * dt * load(v), q_mid);
  store(1.5 * load(v) - 0.5 * load(v_before), v_mid);
}

PALPATE_AVX2_TOO void sum_loads(const arm::LaneDynamics& d, const LeaderJoints& joints, double dt,
                                const Lanes& tau_drives, const Lanes& tau_elastic, const Lanes& q_mid, const Lanes& v,
                                LeaderLoads& loads, HandleLanes& V) noexcept {
  const Pack impulse = dt * load(joints.coulomb), q = load(q_mid), infinity = constant(__builtin_inf());
  store(load(tau_drives) - load(d.bias) - load(tau_elastic), loads.tau);
  store(where_at_most(q, load(joints.q_min), infinity, impulse), loads.hi);
  store(where_at_most(load(joints.q_max), q, -infinity, -impulse), loads.lo);
  store(handle_velocity(d, load(v)), V);
}

PALPATE_AVX2_TOO void pull(const HandLanes& hand, const HandleLanes& error, const double (&v)[3], const double (&w)[3],
                           HandleLanes& F) noexcept {
  store(spring_and_damper(hand, load(error), v, w), F);
}

PALPATE_AVX2_TOO bool pull_towards(const arm::LaneDynamics& d, const HandLanes& hand, const double (&p)[3],
                                   const double (&R)[9], const double (&v)[3], const double (&w)[3], HandleLanes& error,
                                   HandleLanes& F) noexcept {
  const auto* columns = reinterpret_cast<const FourInMemory*>(d.tip);
  Four cross = {}, product = {};
  for (std::size_t i = 0; i < 3; ++i) {
    const Four from = columns[i], to = {R[3 * i], R[3 * i + 1], R[3 * i + 2], 0.0};
    cross += from * __builtin_shufflevector(to, to, 1, 2, 0, 3) - __builtin_shufflevector(from, from, 1, 2, 0, 3) * to;
    product += from * to;
  }
  const Four sine = 0.5 * __builtin_shufflevector(cross, cross, 1, 2, 0, 3), squares = sine * sine;
  const double z = squares[0] + squares[1] + squares[2], trace = product[0] + product[1] + product[2];
  const Pack both = {Four{p[0], p[1], p[2], 0.0} - columns[3], arc_sine_ratio(z) * sine};
  store(both, error);
  store(spring_and_damper(hand, both, v, w), F);
  return z < kSmallSine && trace > 1.0;
}

PALPATE_AVX2_TOO void assemble(const arm::LaneDynamics& d, const LeaderJoints& joints, const HandLanes& hand, double dt,
                               const HandForce& force, const HandleLanes& F_push, const HandleLanes& V,
                               const LeaderLoads& loads, const Lanes& v, Lanes (&A)[kLanes], Lanes& b) noexcept {
  alignas(64) HandleLanes F;
  store(load(force.F) + load(F_push) - load(force.response) * load(V) - load(hand.M) * load(d.Jdot_v), F);
  const Pack rotor = load(joints.rotor), diagonal = rotor + dt * load(joints.viscous);
  Pack tau = load(loads.tau), momentum[2] = {rotor * load(v), {}};  // two sums, so that the second need not wait
  for (int r = 0; r < 6; ++r) tau = tau + F[r < 3 ? r : r + 1] * load(d.J[r]);
  for (int j = 0; j < kLanes; ++j) {
    const Pack row = load(d.M[j]);
    momentum[j % 2] = momentum[j % 2] + v[j] * row;
    store(row + load(kUnit[j]) * diagonal, A[j]);
  }
  store((momentum[0] + momentum[1]) + dt * tau, b);
}

PALPATE_AVX2_TOO double react(const arm::LaneDynamics& d, const HandLanes& hand, double dt, const HandForce& force,
                              const HandleLanes& F_push, const HandleLanes& V, const Lanes& v, const Lanes& v_next,
                              HandleLanes& F, HandleLanes& arm_on_hand) noexcept {
  const Pack dV = handle_velocity(d, load(v_next) - load(v));
  const Pack now = load(force.F) - load(force.response) * (load(V) + dV);
  store(now, F);
  store(load(hand.M) * ((1.0 / dt) * dV + load(d.Jdot_v)) - now - load(F_push), arm_on_hand);
  const Four squares = now.low * now.low;
  return squares[0] + squares[1] + squares[2];
}

PALPATE_AVX2_TOO void to_end(double dt, const LeaderJoints& joints, const Lanes& q_mid, const Lanes& v_next, Lanes& v,
                             Lanes& v_before, Lanes& q) noexcept {
  const Pack next = load(v_next);
  store(load(v), v_before);
  store(next, v);
  store(min(max(load(q_mid) + 0.5 * dt * next, load(joints.q_min)), load(joints.q_max)), q);
}

}  // namespace palpate::plant
