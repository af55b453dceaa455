// A tool with three spheres on random paths, jumps included, through random meshes, boxes and planes, by every method
// that runs in the cycle.
#include <array>
#include <cmath>

#include "palpate/collision/methods.hpp"
#include "palpate/contact/tool.hpp"
#include "palpate/scene/primitives.hpp"
#include "soup.hpp"

namespace {

using fuzz::require;
using palpate::Vec3;

constexpr std::array kMethods = {"proxy", "penalty", "face-normal", "approach-velocity"};
constexpr double kSize = 0.03;  // [m] half the extent of the scene

palpate::scene::Object object(fuzz::Bytes& bytes, const char* method) {
  palpate::scene::Object out;
  const bool triangles = method != kMethods[0] && method != kMethods[1];  // methods that need triangles
  if (!triangles && bytes.below(4) == 0) {
    out.surface = std::make_shared<palpate::scene::Box>(Vec3(0.02, 0.01, 0.001 + 0.01 * bytes.below(3)));
  } else if (!triangles && bytes.below(4) == 0) {
    out.surface = std::make_shared<palpate::scene::Plane>();
  } else {
    out.surface = fuzz::soup(bytes, kSize);
  }
  out.material.mu = 0.1 * static_cast<double>(bytes.below(12));
  out.material.mu_static = 0.1 * static_cast<double>(bytes.below(12));
  const Vec3 shift = bytes.vector(0.01);
  if (shift.allFinite() && shift.norm() < 1.0) out.X_WO.p = shift;
  return out;
}

void check(const palpate::ContactSet& set, const Vec3* p_WS, int spheres) {
  require(set.size >= 0 && set.size <= palpate::kMaxContacts, "the number of contacts is within its bound");
  for (int i = 0; i < set.size; ++i) {
    const palpate::Contact& c = set.contact[static_cast<std::size_t>(i)];
    require(c.sphere >= 0 && c.sphere < spheres, "a contact names its sphere");
    require(c.delta_x.allFinite() && c.normal.allFinite() && c.p_C.allFinite() && c.F_grad_K.allFinite() &&
                std::isfinite(c.depth),
            "a contact is finite");
    require((c.p_proxy - p_WS[c.sphere] - c.delta_x).norm() < 1e-9, "the deflection leads to the proxy");
    require(std::abs(c.normal.norm() - 1.0) < 1e-6, "the normal has length one");
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  palpate::collision::register_methods();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  const char* const method = kMethods[bytes.below(kMethods.size())];
  palpate::contact::Options options;
  options.radius = 0.0005 * static_cast<double>(1 + bytes.below(12));
  options.spheres.resize(2);
  palpate::scene::Snapshot scene;
  for (std::size_t n = 1 + bytes.below(2); n > 0; --n) {
    palpate::scene::Object made = object(bytes, method);
    if (made.surface != nullptr) scene.objects.push_back(std::move(made));
  }
  palpate::contact::Tool tool(method, options);
  std::array<Vec3, 3> p_WS{};
  Vec3 tip(0.0, 0.0, 0.06);
  for (int k = 0; k < 64 && !bytes.empty(); ++k) {
    const bool jumps = bytes.below(16) == 0;
    const Vec3 moved = jumps ? bytes.vector(2.0 * kSize) : Vec3(tip + bytes.vector(0.002));
    if (moved.allFinite() && moved.norm() < 10.0) tip = moved;
    for (std::size_t s = 0; s < p_WS.size(); ++s) p_WS[s] = tip + Vec3(0.0, 0.0, 0.004 * static_cast<double>(s));
    check(tool.step(scene, p_WS.data(), 1e-3 * k), p_WS.data(), tool.size());
    if (bytes.below(64) == 1) tool.reset();
  }
  return 0;
}
