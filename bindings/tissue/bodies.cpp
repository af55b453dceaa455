// Soft bodies.
#include <nanobind/eigen/dense.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "palpate/scene/snapshot.hpp"
#include "palpate/tissue/body.hpp"
#include "palpate/tissue/depth_moduli.hpp"
#include "palpate/tissue/shared_surface.hpp"
#include "palpate/tissue/soft_surface.hpp"
#include "tissue/bindings.hpp"
#include "types.hpp"

namespace nb = nanobind;

namespace palpate::bindings {
namespace {

using tissue::Body;
using tissue::BodyData;
using Tets = Input<std::int32_t, -1, 4>;
using Values = Input<double, -1>;
using Flags = Input<bool, -1>;

template <class Out, class In>
std::vector<Out> copy_of(const In& in) {
  return std::vector<Out>(in.data(), in.data() + in.size());
}

void make_body(Body* self, const Points& nodes, const Tets& tets, const Triangles& surface, const Values& mu,
               const Values& bulk, const Values& density, const Values& yeoh,
               const std::vector<std::pair<double, double>>& prony, const Flags& fixed, const Values& spring,
               double step, double tick, double damping, double mass_limit, bool portable) {
  BodyData data{copy_of<double>(nodes),
                copy_of<std::int32_t>(tets),
                copy_of<std::int32_t>(surface),
                copy_of<double>(mu),
                copy_of<double>(bulk),
                copy_of<double>(density),
                copy_of<double>(yeoh),
                {},
                copy_of<std::uint8_t>(fixed),
                copy_of<double>(spring),
                step,
                tick,
                damping,
                mass_limit,
                portable};
  for (const auto& [g, tau] : prony) data.prony.push_back({g, tau});
  const nb::gil_scoped_release release;
  new (self) Body(std::move(data));
}

Array rows_of(std::vector<double>&& values) {
  const std::size_t n = values.size() / 3;
  return array(std::move(values), {n, 3});
}

Array positions(const Body& body) {
  std::vector<double> x = body.data().nodes;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += body.displacements()[i];
  return rows_of(std::move(x));
}

void set_loads(Body& body, const Points& forces) {
  if (forces.shape(0) != body.node_count())
    throw std::invalid_argument("forces has " + std::to_string(forces.shape(0)) + " rows for " +
                                std::to_string(body.node_count()) + " nodes");
  body.clear_loads();
  for (std::size_t i = 0; i < body.node_count(); ++i) {
    const Vec3 force(forces.data() + 3 * i);
    if (force != Vec3::Zero()) body.add_load(static_cast<std::int32_t>(i), force);
  }
}

void set_state(Body& body, const Points& positions, const Points& velocities) {
  if (positions.shape(0) != body.node_count() || velocities.shape(0) != body.node_count())
    throw std::invalid_argument("positions and velocities must have one row for each of the " +
                                std::to_string(body.node_count()) + " nodes");
  std::vector<double> u(positions.data(), positions.data() + positions.size());
  for (std::size_t i = 0; i < u.size(); ++i) u[i] -= body.data().nodes[i];
  body.set_state(u, {velocities.data(), velocities.size()});
}

nb::class_<Body> bind_body(nb::module_& m) {
  nb::class_<Body> body(
      m, "TissueBody",
      "A soft body of linear tetrahedra, stepped explicitly; all in the object's frame O. Energy per volume: "
      "mu/2 (w + c max(w, 0)^2) + k/2 (J - 1)^2 with w = I1 - 3 - 2 (J - 1), I1 = tr F^T F, J = det F and "
      "k = bulk + mu/3: a stable Neo-Hookean solid (after Smith, de Goes and Kim 2018) with the stiffening of Yeoh "
      "(1993), and a barrier 4 k/2 min(J - .3, 0)^2 against inversion. Prony terms g add the energy g mu/2 |Z - q|^2, "
      "q' = (Z - q) / tau, of a strain Z without change of volume: mu/2 |Z|^2 = mu/2 (w + c w^2) with "
      "w = J^(-2/3) I1 - 3.");
  body.def("__init__", &make_body, nb::kw_only(), nb::arg("nodes"), nb::arg("tets"), nb::arg("surface"), nb::arg("mu"),
           nb::arg("bulk"), nb::arg("density"), nb::arg("yeoh"), nb::arg("prony"), nb::arg("fixed"), nb::arg("spring"),
           nb::arg("step") = 0.0, nb::arg("tick") = 1e-3, nb::arg("damping") = BodyData{}.damping,
           nb::arg("mass_limit") = BodyData{}.mass_limit, nb::arg("portable") = false,
           "nodes (n, 3) [m]; tets (m, 4), surface (k, 3) with outward winding: int32 indices of nodes; mu, bulk (m,) "
           "[Pa]: shear modulus after full relaxation and bulk modulus; density (m,) [kg/m^3]; yeoh (m,): c [-]; "
           "prony: pairs (g [-], tau [s]), sum of g up to 100, tau from 1e-5 to 1000, instantaneous modulus mu (1 + "
           "sum g); fixed (n,) bool; spring (n,) [N/m] to "
           "the rest positions; step [s], 0: chosen so that the added mass stays below mass_limit [-]; tick: period of "
           "the loop [s]; damping: force per mass and velocity [1/s]. Raises ValueError naming the invalid value.");
  return body;
}

void bind_tissue_motion(nb::class_<Body>& body) {
  body.def(
          "step",
          [](Body& body, int n) {
            const nb::gil_scoped_release release;
            for (int i = 0; i < n; ++i) body.step();
          },
          nb::arg("n") = 1, "Advances by n time steps.")
      .def("reset", &Body::reset, "Returns to rest.")
      .def("set_loads", &set_loads, nb::arg("forces"), "Sets the forces on the nodes (n, 3) [N].")
      .def("set_state", &set_state, nb::arg("positions"), nb::arg("velocities"),
           "Sets positions (n, 3) [m] and velocities (n, 3) [m/s].");
}

void bind_readings(nb::class_<Body>& body) {
  body.def("positions", &positions, "Positions of the nodes (n, 3) [m].")
      .def(
          "velocities", [](const Body& body) { return rows_of({body.velocities().begin(), body.velocities().end()}); },
          "Velocities of the nodes (n, 3) [m/s].")
      .def(
          "internal_forces",
          [](Body& body) {
            std::vector<double> out(3 * body.node_count());
            body.internal_forces(out);
            return rows_of(std::move(out));
          },
          "Elastic forces on the nodes at the present positions, without Prony terms and springs (n, 3) [N].")
      .def(
          "masses",
          [](const Body& body) {
            std::vector<double> out(body.masses().begin(), body.masses().end());
            const std::size_t n = out.size();
            return array(std::move(out), {n});
          },
          "Masses of the nodes, added mass included (n,) [kg].")
      .def(
          "energies",
          [](const Body& body) {
            const tissue::BodyEnergy e = body.energy();
            return std::make_pair(e.potential, e.kinetic);
          },
          "(potential, kinetic) [J]; the potential is that at the beginning of the last step.")
      .def(
          "layers",
          [](const Body& body) {
            std::vector<std::int32_t> out(body.layers().begin(), body.layers().end());
            const std::size_t n = out.size();
            return array(std::move(out), {n});
          },
          "Layers of nodes below the free surface near each node, at most 4 (n,): 0 where the body is one tetrahedron "
          "thick, 1 for two or three.")
      .def("stable_step", &Body::stable_step, "Longest stable step without added mass: a bound, at rest [s].")
      .def("added_mass", &Body::added_mass, "Mass added for the time step, as a share of the mass [-].")
      .def_prop_ro("time_step", &Body::time_step, "Time step [s].")
      .def_prop_ro("steps_per_tick", &Body::steps_per_tick, "Steps in a period of the loop.")
      .def_prop_ro("least_volume", &Body::least_volume,
                   "Smallest det F at the beginning of the last step; zero or less: inverted [-].")
      .def_prop_ro_static(
          "has_avx2", [](nb::handle) { return tissue::has_avx2(); }, "True if the AVX2 kernels are used.");
}

using tissue::SoftSurface;

scene::SurfaceLoad load_at(const Vec3& p_OC, const Vec3& normal, double depth, double radius, const Vec3& force) {
  return {{p_OC, normal, depth, radius, 0}, force};
}

/// The copy of a loop, for tests: a contact of one sphere presses it.
void bind_own(nb::class_<SoftSurface, scene::Surface>& surface) {
  surface
      .def(
          "own", [](const SoftSurface& self) { return std::static_pointer_cast<SoftSurface>(self.at_rest()); },
          "A copy at rest, as each loop makes one.")
      .def(
          "advance",
          [](SoftSurface& self, const Vec3& p, const Vec3& normal, double depth, double radius, const Vec3& force,
             double dt) {
            const scene::SurfaceLoad load = load_at(p, normal, depth, radius, force);
            self.advance({&load, depth > 0.0 ? 1u : 0u}, dt);
          },
          nb::arg("p"), nb::arg("normal"), nb::arg("depth"), nb::arg("radius"), nb::arg("force"), nb::arg("dt") = 1e-3,
          "Advances a loop's copy by a tick under the contact of one sphere. p: contact point (3,) [m]; normal: unit "
          "(3,), outwards; depth, radius [m]; force on the tool (3,) [N]; all in O.")
      .def(
          "respond",
          [](const SoftSurface& self, const Vec3& p, const Vec3& normal, double depth, double radius) {
            return self.respond({p, normal, depth, radius, 0}).force;
          },
          nb::arg("p"), nb::arg("normal"), nb::arg("depth"), nb::arg("radius"), "Normal force on a sphere [N].")
      .def(
          "near_field",
          [](const SoftSurface& self, const Vec3& p, const Vec3& normal, double depth, double radius) {
            const scene::Response r = self.respond({p, normal, depth, radius, 0});
            return Tuple<double, double, double>(nb::make_tuple(r.force, r.tangent, r.stored));
          },
          nb::arg("p"), nb::arg("normal"), nb::arg("depth"), nb::arg("radius"),
          "(force [N], its derivative by the depth [N/m], energy [J]) of the near field.")
      .def("set_beside", &SoftSurface::set_beside, nb::arg("beside"), "True: work() steps the body, not advance().")
      .def("work", &SoftSurface::work, "Steps the body by a period if it is due. Returns True if it was.")
      .def(
          "set_state",
          [](SoftSurface& self, const Points& displacements, const Points& velocities) {
            const std::size_t n = 3 * self.body().node_count();
            if (displacements.size() != n || velocities.size() != n)
              throw std::invalid_argument("displacements and velocities must have one row per node");
            self.pressed().set_state({displacements.data(), n}, {velocities.data(), n});
          },
          nb::arg("displacements"), nb::arg("velocities"),
          "Sets displacements (n, 3) [m] and velocities (n, 3) [m/s] of all nodes, for tests of the guard.")
      .def(
          "state",
          [](const SoftSurface& self) {
            const scene::DeformableState s = self.state();
            return Tuple<double, double, bool, bool, bool>(
                nb::make_tuple(s.potential, s.kinetic, s.hurried, s.frozen, s.late));
          },
          "(potential [J], kinetic [J], hurried, frozen, late), as in the signal tissue_status.");
}

/// The mesh of a soft surface at rest.
template <class Soft>
void bind_rest(nb::class_<Soft, scene::Surface>& surface) {
  surface
      .def_prop_ro(
          "vertices",
          [](const Soft& self) {
            const std::span<const double> x = self.mesh()->vertices();
            return rows_of({x.begin(), x.end()});
          },
          "Vertices of the surface at rest (n, 3), in O [m].")
      .def_prop_ro(
          "triangles",
          [](const Soft& self) {
            const std::span<const std::int32_t> t = self.mesh()->triangles();
            return array(std::vector<std::int32_t>(t.begin(), t.end()), {t.size() / 3, 3});
          },
          "Triangles of the surface (m, 3), wound outwards.");
}

void bind_shared(nb::module_& m) {
  nb::class_<tissue::SharedSurface, scene::Surface> surface(m, "SharedTissue",
                                                            "The surface of a soft body that loops share.");
  bind_rest(surface);
  surface.def(
      "displacements", [](const tissue::SharedSurface& self) { return rows_of(self.shared().displacements()); },
      "Displacements of the nodes of the body (n, 3) [m].");
  m.def(
      "share_bodies",
      [](const scene::Snapshot& given) {
        scene::Snapshot made = given;
        for (scene::Object& object : made.objects) {
          const auto* soft = dynamic_cast<const SoftSurface*>(object.surface.get());
          if (soft != nullptr) object.surface = std::make_shared<tissue::SharedSurface>(*soft);
        }
        return std::make_shared<scene::Snapshot>(std::move(made));
      },
      nb::arg("snapshot"),
      "The snapshot with soft bodies that all its loops share: one body each, which the tools of all loops press in "
      "the cycle.");
}

}  // namespace

void bind_bodies(nb::module_& m) {
  m.attr("YEOH_GROWTH") = tissue::kYeoh;
  nb::class_<Body> body = bind_body(m);
  bind_tissue_motion(body);
  bind_readings(body);
  nb::class_<SoftSurface, scene::Surface> surface(
      m, "TissueSurface", "The surface of a soft body, for contact. Each loop and each rendering uses a copy at rest.");
  surface
      .def(
          "__init__",
          [](SoftSurface* self, const Body& body, double width, double period, const SoftSurface* like) {
            const nb::gil_scoped_release release;
            new (self) SoftSurface(body, width, period, like == nullptr ? 0 : like->id());
          },
          nb::arg("body"), nb::arg("width") = 0.0, nb::arg("period") = 0.0, nb::arg("like").none() = nb::none(),
          "body: gives the mesh, the material and the step; its state is not used. width: standard deviation of the "
          "spread contact force [m], 0: .7 of the mean edge. period: by "
          "which the body steps beside the cycle [s]; 0: in every tick. like: another surface of the same body, which "
          "fixtures know. Raises ValueError if the body has no surface or the period is not from 0 to 0.05 s.")
      .def_prop_ro("edge", &SoftSurface::edge, "Mean length of the edges of the surface [m].")
      .def_prop_ro("width", &SoftSurface::width, "Standard deviation of the spread contact force [m].")
      .def_prop_ro("period", &SoftSurface::period, "Period of the steps beside the cycle [s]; 0: in every tick.");
  surface.def(
      "set_patient", &SoftSurface::set_patient, nb::arg("patient"),
      "True: a loop that runs more than twice as fast as real time waits for the thread beside it. Copies at rest "
      "inherit it.");
  bind_rest(surface);
  bind_own(surface);
  bind_shared(m);
}

}  // namespace palpate::bindings
