#include "palpate/force/force.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>

#include <memory>
#include <optional>
#include <stdexcept>

#include "bindings.hpp"
#include "convert.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

auto force_step(const Rows& K, const Rows& B, const Rows& normal, const Rows& delta_x, const Vec3& v_WT,
                const Rows& v_surface, double stiffness_scale, double damping_scale, const Vec3& w_WT,
                const std::optional<Rows>& p_TS) {
  const Eigen::Index n = normal.rows();
  if (n > contact::kMaxContacts || K.rows() != n || B.rows() != n || delta_x.rows() != n || v_surface.rows() != n ||
      (p_TS && p_TS->rows() != n)) {
    throw std::invalid_argument("K, B, normal, delta_x, v_surface and p_TS must all have shape (n, 3), n <= " +
                                std::to_string(contact::kMaxContacts));
  }
  contact::ContactSet contacts;
  contacts.size = static_cast<int>(n);
  for (int i = 0; i < contacts.size; ++i) {
    contact::Contact& c = contacts.contact[static_cast<std::size_t>(i)];
    c.object = i;
    c.material = {K.row(i), B.row(i), 0.0};
    c.normal = normal.row(i);
    c.delta_x = delta_x.row(i);
    c.depth = c.delta_x.dot(c.normal);
    c.v_surface = v_surface.row(i);
    if (p_TS) c.p_TS = p_TS->row(i);
  }
  const force::ForceTerms terms = force::step(contacts, {v_WT, w_WT}, stiffness_scale, damping_scale);
  return std::make_tuple(terms.F, terms.F_spring, terms.F_damping, terms.torque);
}

}  // namespace

void bind_force(nb::module_& m) {
  m.def(
      "force", &force_step, "K"_a, "B"_a, "normal"_a, "delta_x"_a, "v_WT"_a, "v_surface"_a, "stiffness_scale"_a = 1.0,
      "damping_scale"_a = 1.0, "w_WT"_a = Vec3(Vec3::Zero()), "p_TS"_a = nb::none(),
      "Stage `force` on n contacts given as (n, 3) arrays: (F, F_spring, F_damping) [N], torque about T [N m], in W.");
}

}  // namespace palpate::bindings
