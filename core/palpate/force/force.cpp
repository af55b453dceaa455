#include "palpate/force/force.hpp"

#include <algorithm>
#include <cstddef>

namespace palpate::force {

ForceTerms step(const ContactSet& contacts, const Twist& V_WT, double stiffness_scale, double damping_scale) noexcept {
  ForceTerms sum;
  for (int i = 0; i < contacts.size; ++i) {
    const Contact& c = contacts.contact[static_cast<std::size_t>(i)];
    const Material& material = c.material;
    const Vec3& n = c.normal;

    const Vec3 F_spring = stiffness_scale * spring_force(c);

    const double b = damping_scale * n.dot(material.B.cwiseProduct(n));
    const Vec3 v_WS = V_WT.v + V_WT.w.cross(c.p_TS);
    const double damping = -b * n.dot(v_WS - c.v_surface);
    const double F_damping_n = std::max(damping, -n.dot(F_spring));  // the total force along n stays >= 0

    sum.F_spring += F_spring;
    sum.F_damping += F_damping_n * n;
    sum.t_damping += c.p_TS.cross(F_damping_n * n);
    const Wrench F_T_W = {F_spring + F_damping_n * n, c.p_TS.cross(F_spring + F_damping_n * n)};
    sum.torque += F_T_W.t;
    sum.F_contact[static_cast<std::size_t>(i)] = F_T_W;
  }
  sum.F = sum.F_spring + sum.F_damping;
  return sum;
}

}  // namespace palpate::force
