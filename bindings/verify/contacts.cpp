#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "doc.hpp"
#include "palpate/contact/tool.hpp"
#include "palpate/scene/snapshot.hpp"
#include "types.hpp"
#include "verify/bindings.hpp"

namespace nb = nanobind;

namespace palpate::bindings {
namespace {

using Centres = Input<double, -1, -1, 3>;
using Numbers = Input<std::int32_t, -1>;

/// Moves the spheres of a tool along prescribed paths through scenes that are replaced as in a loop.
Array touched(const std::vector<std::shared_ptr<scene::Snapshot>>& scenes, const Numbers& scene, const Centres& centres,
              const Numbers& resets, const std::string& method, const contact::Options& options, double rate) {
  contact::Tool tool(method, options);
  const std::size_t n = centres.shape(0), spheres = centres.shape(1);
  if (spheres != static_cast<std::size_t>(tool.size()) || scene.shape(0) != n || resets.shape(0) != n)
    throw std::invalid_argument("centres must be (n, spheres of the tool, 3), scene and resets (n,)");
  std::size_t objects = 0;
  for (const auto& one : scenes) {
    tool.check(*one);
    objects = std::max(objects, one->objects.size());
  }
  const std::size_t size = n * spheres * objects;
  auto* const depth = new double[size]();
  nb::capsule owner(depth, [](void* p) noexcept { delete[] static_cast<double*>(p); });
  scene::Snapshot shown;
  std::array<Vec3, contact::kMaxSpheres> p_WS;
  for (std::size_t i = 0; i < n; ++i) {
    if (i == 0 || scene.data()[i] != scene.data()[i - 1]) {
      shown = *scenes.at(static_cast<std::size_t>(scene.data()[i]));
      scene::seal(shown);
    }
    if (resets.data()[i] != 0) tool.reset();
    for (std::size_t s = 0; s < spheres; ++s) p_WS[s] = Vec3(centres.data() + 3 * (i * spheres + s));
    const ContactSet& found = tool.step(shown, p_WS.data(), static_cast<double>(i) / rate);
    for (int k = 0; k < found.size; ++k) {
      const Contact& c = found.contact[static_cast<std::size_t>(k)];
      const auto at = (i * spheres + static_cast<std::size_t>(c.sphere)) * objects + static_cast<std::size_t>(c.object);
      depth[at] = c.depth;
    }
  }
  return Array(nb::cast(nb::ndarray<nb::numpy, double>(depth, {n, spheres, objects}, owner)));
}

}  // namespace

void bind_contacts(nb::module_& m) {
  m.def("touched", &touched, nb::arg("scenes"), nb::arg("scene"), nb::arg("centres"), nb::arg("resets"),
        nb::arg("method"), nb::arg("options"), nb::arg("rate") = 1000.0,
        "Depth (n, spheres, objects) of each contact of a tool [m], 0 without, in n ticks. centres: of its spheres in "
        "W (n, spheres, 3) [m]; scene: (n,) number of the snapshot in each tick, which is handed over as to a loop "
        "where it changes; resets: (n,) not 0 where the tool is reset before the tick.");
}

}  // namespace palpate::bindings
