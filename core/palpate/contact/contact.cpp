#include "palpate/contact/contact.hpp"

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "palpate/contact/approach_velocity.hpp"
#include "palpate/contact/face_normal.hpp"
#include "palpate/contact/paper_alg1.hpp"
#include "palpate/contact/paper_plane.hpp"
#include "palpate/contact/penalty.hpp"
#include "palpate/contact/proxy.hpp"

namespace palpate::contact {
namespace {

struct Entry {
  std::string_view name;
  std::unique_ptr<Method> (*make)(const Options&);
};

template <class T>
std::unique_ptr<Method> make(const Options& options) {
  return std::make_unique<T>(options);
}

template <class R>
std::unique_ptr<NormalRule> make_rule() {
  return std::make_unique<R>();
}

template <class R>
std::unique_ptr<Method> make_collision(const Options& options) {
  return std::make_unique<CollisionMethod>(options, &make_rule<R>);
}

/// Table of all contact methods. A new method needs one file and one line here.
constexpr std::array kMethods = {
    Entry{"proxy", &make<Proxy>},
    Entry{"penalty", &make<Penalty>},
    Entry{"paper-plane", &make_collision<PaperPlane>},
    Entry{"paper-alg1", &make_collision<PaperAlg1>},
    Entry{"face-normal", &make_collision<FaceNormal>},
    Entry{"approach-velocity", &make_collision<ApproachVelocity>},
};

}  // namespace

std::vector<std::string> methods() {
  std::vector<std::string> names;
  names.reserve(kMethods.size());
  for (const Entry& entry : kMethods) names.emplace_back(entry.name);
  return names;
}

Vec3 ToolSphere::centre(double jaw) const noexcept {
  const double length = axis.norm();
  return length > 0.0 ? Vec3(hinge + Eigen::AngleAxisd(length * jaw, axis / length) * (p - hinge)) : p;
}

std::unique_ptr<Method> make_method(std::string_view name, const Options& options) {
  if (!(options.radius > 0.0) || !std::isfinite(options.radius))
    throw std::invalid_argument("contact: radius must be a positive length in metres, got " +
                                std::to_string(options.radius));
  std::string known;
  for (const Entry& entry : kMethods) {
    if (entry.name == name) return entry.make(options);
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw std::invalid_argument("contact: no method '" + std::string(name) + "'; there are: " + known);
}

}  // namespace palpate::contact
