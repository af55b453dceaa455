#include "palpate/contact/contact.hpp"

#include <nanobind/eigen/dense.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <chrono>

#include "bindings.hpp"
#include "palpate/contact/paper_plane.hpp"
#include "palpate/force/force.hpp"

namespace nb = nanobind;

namespace palpate::bindings {
namespace {

using Rows = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Clock = std::chrono::steady_clock;

/// Row views of one output array, owned by Python.
struct Output {
  explicit Output(std::size_t n, std::size_t columns) : values(new double[n * columns]()), width(columns), rows(n) {}
  double* values;
  std::size_t width, rows;

  double* row(std::size_t i) const { return values + width * i; }
  nb::object take() {
    nb::capsule owner(values, [](void* p) noexcept { delete[] static_cast<double*>(p); });
    return width == 1 ? nb::cast(nb::ndarray<nb::numpy, double>(values, {rows}, owner))
                      : nb::cast(nb::ndarray<nb::numpy, double>(values, {rows, width}, owner));
  }
};

/// Runs a prescribed tool path through the method and the force law of the loop, each update timed.
nb::tuple render(const scene::Snapshot& scene, const Rows& tips, const std::string& method_name,
                 const contact::Options& options, double rate) {
  const std::size_t n = tips.shape(0);
  const std::unique_ptr<contact::Method> method = contact::make_method(method_name, options);
  method->check(scene);
  Output force(n, 3), normal(n, 3), depth(n, 1), proxy(n, 3), latency(n, 1);
  bool started_inside = false;
  {
    const nb::gil_scoped_release release;
    method->collide(scene);  // an asynchronous method prepares its meshes
    Vec3 previous = n > 0 ? Vec3(tips.data()) : Vec3::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 p_WT(tips.data() + 3 * i);
      const Vec3 v_WT = (p_WT - previous) * rate;
      previous = p_WT;
      const Clock::time_point start = Clock::now();
      if (method->asynchronous() && i > 0) method->collide(scene);  // lockstep: the answer to the last step
      const contact::ContactSet& contacts = method->step(scene, p_WT, v_WT, static_cast<double>(i) / rate);
      const force::ForceTerms terms = force::step(contacts, {v_WT, Vec3::Zero()}, 1.0, 1.0);
      *latency.row(i) = std::chrono::duration<double>(Clock::now() - start).count();

      Vec3::Map(force.row(i)) = terms.F;
      Vec3::Map(proxy.row(i)) = contacts.size > 0 ? contacts.contact[0].p_proxy : p_WT;
      if (contacts.size > 0) {
        Vec3::Map(normal.row(i)) = contacts.contact[0].normal;
        *depth.row(i) = contacts.contact[0].depth;
      }
      started_inside |= contacts.started_inside;
    }
  }
  return nb::make_tuple(force.take(), normal.take(), depth.take(), proxy.take(), latency.take(), started_inside);
}

Vec3 grow_plane(const Rows& points, const Vec3& n_last, double baseline) {
  std::vector<Vec3> rows;
  for (std::size_t i = 0; i < points.shape(0); ++i) rows.emplace_back(points.data() + 3 * i);
  return contact::grow_plane(rows, n_last, baseline);
}

}  // namespace

void bind_contact(nb::module_& m) {
  nb::class_<contact::Options>(m, "ContactOptions", "The spherical proxy region on the tool tip.")
      .def(nb::init<>())
      .def_rw("radius", &contact::Options::radius, "of the SPR [m]")
      .def_rw("collision_rate", &contact::Options::collision_rate,
              "of the collision thread of the paper's methods [Hz]");
  m.def("contact_methods", &contact::methods, "Names of the contact methods there are; the default first.");
  m.def(
      "contact_check",
      [](const std::string& method, const contact::Options& options, const scene::Snapshot& scene) {
        contact::make_method(method, options)->check(scene);
      },
      nb::arg("method"), nb::arg("options"), nb::arg("snapshot"),
      "ValueError when there is no such method, or it cannot feel an object of the scene.");
  m.def("grow_plane", &grow_plane, nb::arg("points"), nb::arg("n_last"), nb::arg("baseline"),
        "Normal (3,) of the plane that `paper-plane` grows through points (n, 3) [m]; zero where it refuses.");
  m.def("contact_render", &render, nb::arg("snapshot"), nb::arg("tips"), nb::arg("method"), nb::arg("options"),
        nb::arg("rate"),
        "A tool path p_WT (n, 3) [m] at `rate` [Hz] through contact and force -> force, normal, depth, proxy, latency, "
        "started_inside.");
}

}  // namespace palpate::bindings
