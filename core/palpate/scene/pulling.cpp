#include "palpate/scene/pulling.hpp"

#include <array>
#include <cmath>
#include <cstdio>

#include "palpate/scene/mesh.hpp"
#include "palpate/types/index.hpp"

namespace palpate::scene {
namespace {

constexpr int kPlaces = 600;  // directions from a region's box in which its blend is searched
constexpr std::array kShares{0.05, 0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95};  // places across the blend
constexpr double kPullRounding = 1e-6;                                                     // of the excess

/// Element i of the van der Corput sequence in a base, in [0, 1).
double van_der_corput(int i, int base) {
  double value = 0.0, step = 1.0;
  for (; i > 0; i /= base) value += (step /= base) * (i % base);
  return value;
}

bool softer(const Region& region, const Object& object) {
  Vec3 most = object.material.K;
  for (const Region& other : object.regions) most = most.cwiseMax(other.material.K);
  return (region.material.K.array() < most.array()).any();
}

/// The pull at p_O, if the deepest point of a sphere enters the region there as it goes deeper. (Leaving a hard region
/// at its far side, deeper than the region, is not judged.)
Pull pull_at(const Object& object, const Region& region, const Vec3& p_O) {
  const Nearest near = object.surface->nearest(p_O);
  const Mesh* const mesh = object.surface->mesh();
  const bool open = mesh != nullptr && !mesh->report().closed;
  Pull out;
  out.p_O = p_O;
  out.depth = open ? std::abs(near.distance) : -near.distance;
  if (!(out.depth > 0.0)) return out;
  const Vec3 out_of_it = (near.point - p_O) / out.depth, n = object.X_WO.R * out_of_it;
  Vec3 slope;
  region.weight(p_O, slope);
  if (!(slope.dot(out_of_it) < 0.0)) return out;
  const LocalMaterial local = object.material_at(p_O);
  const double K = n.dot(local.material.K.cwiseProduct(n));
  const double on_the_way = n.dot(object.material.K.cwiseProduct(n));
  if (!(K > 0.0) || on_the_way * out.depth > kMostPressed) return out;
  out.excess = 0.5 * out.depth * n.cwiseAbs2().dot(local.dK * out_of_it) / K;
  return out;
}

/// A point of a region's box and a direction in which the region's blend lies beyond it: from its corners, and from its
/// faces.
struct Outwards {
  Vec3 from, direction;
};

Outwards outwards(const Vec3& half, int i) {
  const double z = 2.0 * van_der_corput(i, 2) - 1.0, turn = 2.0 * M_PI * van_der_corput(i, 3);
  const double ring = std::sqrt(1.0 - z * z);
  const Vec3 away(ring * std::cos(turn), ring * std::sin(turn), z);
  if (i % 2 != 0) return {away.cwiseSign().cwiseProduct(half), away};
  int axis = 0;
  away.cwiseAbs().maxCoeff(&axis);
  Outwards out{half.cwiseProduct(Vec3(2.0 * van_der_corput(i, 5) - 1.0, 2.0 * van_der_corput(i, 7) - 1.0,
                                      2.0 * van_der_corput(i, 11) - 1.0)),
               Vec3::Zero()};
  out.direction[axis] = away[axis] < 0.0 ? -1.0 : 1.0;
  out.from[axis] = half[axis] * out.direction[axis];
  return out;
}

/// The least factor from 1 to `most` for which the object that `make` returns does not pull; 0: none found.
template <class Make>
double least_factor(double most, const Make& make) {
  if (strongest_pull(make(most))) return 0.0;
  double pulls = 1.0;
  while (most > 1.02 * pulls) {
    const double middle = std::sqrt(pulls * most);
    (strongest_pull(make(middle)) ? pulls : most) = middle;
  }
  return most;
}

}  // namespace

std::optional<Pull> strongest_pull(const Object& object) {
  Pull worst;
  for (std::size_t k = 0; k < object.regions.size(); ++k) {
    const Region& region = object.regions[k];
    if (!softer(region, object)) continue;
    for (int i = 1; i <= kPlaces; ++i) {
      const Outwards way = outwards(region.half, i);
      for (const double share : kShares) {
        Pull here =
            pull_at(object, region, region.centre + way.from + (region.radius + share * region.blend) * way.direction);
        here.region = static_cast<int>(k);
        if (here.excess > worst.excess) worst = here;
      }
    }
  }
  return worst.excess > 1.0 + kPullRounding ? std::optional(worst) : std::nullopt;
}

std::string words(const Object& object, const Pull& pull) {
  const Region& region = object.regions[to_index(pull.region)];
  const auto with = [&](double blend, double stiffness) {
    Object other = object;
    other.regions[to_index(pull.region)].blend *= blend;
    other.regions[to_index(pull.region)].material.K *= stiffness;
    return other;
  };
  const double blend = least_factor(50.0, [&](double f) { return with(f, 1.0); });
  const double stiffness = least_factor(100.0, [&](double f) { return with(1.0, f); });
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(),
                "region %d of '%s' is so much softer than what surrounds it that it would pull the tool in, %.2g mm "
                "below the surface at (%.3g, %.3g, %.3g) m; ",
                pull.region, object.name.c_str(), 1e3 * pull.depth, pull.p_O.x(), pull.p_O.y(), pull.p_O.z());
  std::string out = text.data();
  std::snprintf(text.data(), text.size(), "give it a blend of at least %.3g mm, or ", 1e3 * blend * region.blend);
  if (blend > 0.0) out += text.data();
  std::snprintf(text.data(), text.size(), "a stiffness of at least %.3g N/m", stiffness * region.material.K.maxCoeff());
  return out + (stiffness > 0.0 ? text.data() : "the stiffness of its surroundings");
}

}  // namespace palpate::scene
