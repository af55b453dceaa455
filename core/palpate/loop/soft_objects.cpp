#include "palpate/loop/soft_objects.hpp"

#include <array>
#include <cstddef>

#include "palpate/types/index.hpp"

namespace palpate::loop {

void advance_soft(const scene::Snapshot& scene, const contact::Tool& tool, const ContactSet& contacts,
                  const force::ForceTerms& forces, double t, double dt) noexcept {
  scene::for_each_soft(scene, [&](std::size_t k, scene::Deformable& soft) noexcept {
    const Pose X_OW = scene.objects[k].pose(t).inverse();
    std::array<scene::SurfaceLoad, kMaxContacts> loads;
    std::size_t n = 0;
    for (int i = 0; i < contacts.size; ++i) {
      const Contact& c = contacts.contact[to_index(i)];
      if (to_index(c.object) != k) continue;
      const double radius = tool.radius(c.sphere);
      const Vec3 p_WC = c.p_proxy - c.delta_x - (radius - c.depth) * c.normal;
      loads[n++] = {{X_OW * p_WC, X_OW.R * c.normal, c.depth, radius, c.sphere},
                    X_OW.R * forces.F_contact[to_index(i)].f,
                    X_OW.R * c.material.K.cwiseProduct(c.lag_to_come)};
    }
    soft.advance({loads.data(), n}, dt);
  });
}

scene::DeformableState soft_state(const scene::Snapshot& scene) noexcept {
  scene::DeformableState sum;
  scene::for_each_soft(scene, [&](std::size_t, scene::Deformable& soft) noexcept {
    const scene::DeformableState one = soft.state();
    sum.potential += one.potential;
    sum.kinetic += one.kinetic;
    sum.hurried |= one.hurried;
    sum.frozen |= one.frozen;
    sum.late |= one.late;
  });
  return sum;
}

}  // namespace palpate::loop
