#include <nanobind/eigen/dense.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <chrono>
#include <optional>
#include <stdexcept>
#include <string>

#include "bindings.hpp"
#include "convert.hpp"
#include "doc.hpp"
#include "palpate/contact/friction.hpp"
#include "palpate/contact/tool.hpp"
#include "palpate/force/force.hpp"
#include "palpate/loop/soft_objects.hpp"
#include "palpate/scene/pulling.hpp"
#include "palpate/types/so3.hpp"
#include "types.hpp"

namespace nb = nanobind;

namespace palpate::bindings {
namespace {

using Clock = std::chrono::steady_clock;

/// A numpy array that is filled row by row; Python owns its memory.
struct Output {
  explicit Output(std::size_t n, std::size_t columns) : values(new double[n * columns]()), width(columns), rows(n) {}
  double* values;
  std::size_t width, rows;

  double* row(std::size_t i) const { return values + width * i; }
  Array take() {
    nb::capsule owner(values, [](void* p) noexcept { delete[] static_cast<double*>(p); });
    using Numpy = nb::ndarray<nb::numpy, double>;
    return Array(nb::cast(width == 1 ? Numpy(values, {rows}, owner) : Numpy(values, {rows, width}, owner)));
  }
};

/// Places the object at poses[i]; its velocity is the backward difference of the poses, as for the tool.
void move(scene::Object& object, const Poses& poses, std::size_t i, double rate) {
  const auto pose = [&](std::size_t k) {
    const Eigen::Map<const RowMat4> X(poses.data() + 16 * k);
    return Pose{X.topLeftCorner<3, 3>(), X.topRightCorner<3, 1>()};
  };
  const Pose now = pose(i), before = pose(i > 0 ? i - 1 : 0);
  const Vec3 turned = rotation_vector(now.R * before.R.transpose());
  object.X_WO = now;
  object.motion = {{(now.p - before.p) * rate, turned * rate}, {}, now.p, static_cast<double>(i) / rate};
}

/// Runs a prescribed tool path through the contact and force stages of the loop and times each update. The tool does
/// not rotate: its spheres keep their offsets from the tip.
Tuple<Array, Array, Array, Array, Array, bool, Array> render(scene::Snapshot scene, const Points& tips,
                                                             const std::string& method_name,
                                                             const contact::Options& options, double rate,
                                                             const std::optional<Poses>& poses) {
  const std::size_t n = tips.shape(0);
  scene = scene::with_own_deformables(std::move(scene));
  contact::Tool tool(method_name, options);
  tool.check(scene);
  if (poses && (poses->shape(0) != n || scene.objects.size() != 1))
    throw std::invalid_argument("poses must have one pose for each tip, and the scene one object; got " +
                                std::to_string(poses->shape(0)) + " poses, " + std::to_string(n) + " tips and " +
                                std::to_string(scene.objects.size()) + " objects");
  Output force(n, 3), normal(n, 3), depth(n, 1), proxy(n, 3), latency(n, 1), torque(n, 3);
  bool started_inside = false;
  {
    const nb::gil_scoped_release release;
    tool.collide(scene);  // the first call makes an asynchronous method prepare its meshes
    std::array<Vec3, contact::kMaxSpheres> p_WS;
    Vec3 previous = n > 0 ? Vec3(tips.data()) : Vec3::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 p_WT(tips.data() + 3 * i);
      const Twist V_WT{(p_WT - previous) * rate, Vec3::Zero()};
      p_WS[0] = p_WT;
      if (p_WT.allFinite()) previous = p_WT;
      for (std::size_t s = 0; s < options.spheres.size(); ++s) p_WS[s + 1] = p_WT + options.spheres[s].p;
      const Clock::time_point start = Clock::now();
      if (tool.asynchronous() && i > 0) tool.collide(scene);  // lockstep: contacts of the previous step
      if (poses) move(scene.objects[0], *poses, i, rate);
      const ContactSet& contacts = tool.step(scene, p_WS.data(), static_cast<double>(i) / rate);
      const force::ForceTerms terms = force::step(contacts, V_WT, 1.0, 1.0);
      loop::advance_soft(scene, tool, contacts, terms, static_cast<double>(i) / rate, 1.0 / rate);
      *latency.row(i) = std::chrono::duration<double>(Clock::now() - start).count();

      Vec3::Map(force.row(i)) = terms.F;
      Vec3::Map(torque.row(i)) = terms.torque;
      Vec3::Map(proxy.row(i)) = contacts.size > 0 ? contacts.contact[0].p_proxy : p_WT;
      if (contacts.size > 0) {
        Vec3::Map(normal.row(i)) = contacts.contact[0].normal;
        *depth.row(i) = contacts.contact[0].depth;
      }
      started_inside |= contacts.started_inside;
    }
  }
  return nb::make_tuple(force.take(), normal.take(), depth.take(), proxy.take(), latency.take(), started_inside,
                        torque.take());
}

}  // namespace

void bind_contact(nb::module_& m) {
  using contact::ToolSphere;
  nb::class_<ToolSphere>(m, "ToolSphere", "A sphere of the tool, in addition to the SPR on its tip.")
      .def(
          "__init__",
          [](ToolSphere* self, const Vec3& p, double radius, int link, const Vec3& hinge, const Vec3& axis) {
            new (self) ToolSphere{link, p, radius, hinge, axis};
          },
          nb::arg("p"), nb::arg("radius"), nb::arg("link") = -1, nb::arg("hinge") = Vec3(Vec3::Zero()),
          nb::arg("turn") = Vec3(Vec3::Zero()),
          "hinge, turn: of a sphere on a jaw, a point on the jaw's axis (3,) [m] and the axis times the rotation per "
          "jaw angle (3,) [-], in the link's frame.")
      .def_ro("p", &ToolSphere::p, "Centre in the link's frame with the jaws closed (3,) [m]."_doc)
      .def_ro("radius", &ToolSphere::radius, "Radius [m]."_doc)
      .def_ro("link", &ToolSphere::link,
              "Index of the follower's link that carries the sphere; negative: the tool tip T."_doc)
      .def("centre", &ToolSphere::centre, nb::arg("jaw"),
           "Centre in the link's frame with the jaws open by `jaw` [rad] (3,) [m].");
  nb::class_<contact::Options>(m, "ContactOptions", "Options of the contact stage.")
      .def(nb::init<>())
      .def_rw("radius", &contact::Options::radius,
              "Radius of the spherical proxy region (SPR) on the tool tip [m]."_doc)
      .def_rw(
          "release", &contact::Options::release,
          "Deflection above which a tool that passed through a closed object is released, for the method `proxy` [m]."_doc)
      .def_rw("collision_rate", &contact::Options::collision_rate,
              "Rate of the collision thread, for the paper's methods [Hz]."_doc)
      .def_rw("real", &contact::Options::real_objects,
              "True: the tool touches the real objects, not the virtual ones."_doc)
      .def_rw("objects", &contact::Options::objects, "Largest number of objects in a scene."_doc)
      .def_rw("spheres", &contact::Options::spheres,
              "Spheres of the tool in addition to the SPR. This is a copy: assign a whole list."_doc);
  nb::class_<contact::Friction>(m, "Friction", "Coulomb friction of one proxy, with sticking and slipping.")
      .def(nb::init<>())
      .def(
          "step",
          [](contact::Friction& self, const Vec3& x, const Vec3& normal, double depth, double mu, double mu_static,
             double k, double dt) { return self.step({x, normal, depth, k, mu, mu_static, dt}); },
          nb::arg("x"), nb::arg("normal"), nb::arg("depth"), nb::arg("mu"), nb::arg("mu_static"), nb::arg("k") = 1.0,
          nb::arg("dt") = 1e3,
          "Distance (3,) [m] by which friction holds the tool back; the force is k times that. x: tool (3,) [m]; "
          "normal: "
          "unit (3,); depth [m]; mu, mu_static [-]; k: stiffness [N/m]; dt: time since the last step [s], by default "
          "long enough to break away at once.")
      .def_prop_ro("slipping", &contact::Friction::slipping, "True while the proxy slips.");
  m.attr("MAX_SPHERES") = contact::kMaxSpheres;
  m.def("contact_methods", &contact::methods, "Names of the contact methods, the default first.");
  m.def(
      "contact_check",
      [](const std::string& method, const contact::Options& options, const scene::Snapshot& scene) {
        contact::make_method(method, options)->check(scene);
      },
      nb::arg("method"), nb::arg("options"), nb::arg("snapshot"),
      "Raises ValueError if the method does not exist or cannot render an object of the scene.");
  m.def(
      "region_pull",
      [](const scene::Object& object) -> std::optional<Tuple<int, std::string>> {
        const auto pull = scene::strongest_pull(object);
        if (!pull) return std::nullopt;
        return nb::make_tuple(pull->region, scene::words(object, *pull));
      },
      nb::arg("object"),
      "Index of the region of an object that would pull the tool in the most, and what to change; None if none does.");
  m.def("contact_render", &render, nb::arg("snapshot"), nb::arg("tips"), nb::arg("method"), nb::arg("options"),
        nb::arg("rate"), nb::arg("poses") = nb::none(),
        "Runs the stages contact and force along a tool path p_WT (n, 3) [m], sampled at rate [Hz]. poses: X_WO (n, 4, "
        "4) of the scene's only object. Returns force (n, 3) [N], normal (n, 3), depth (n,) [m], proxy (n, 3) [m], "
        "latency (n,) [s], started_inside, torque (n, 3) [N m]; all in W.");
}

}  // namespace palpate::bindings
