#include "palpate/collision/methods.hpp"

#include <memory>

#include "palpate/collision/approach_velocity.hpp"
#include "palpate/collision/face_normal.hpp"
#include "palpate/collision/paper_alg1.hpp"
#include "palpate/collision/paper_plane.hpp"
#include "palpate/contact/registry.hpp"

namespace palpate::collision {
namespace {

template <class R>
std::unique_ptr<NormalRule> make_rule() {
  return std::make_unique<R>();
}

template <class R>
std::unique_ptr<contact::Method> make(const contact::Options& options) {
  return std::make_unique<CollisionMethod>(options, &make_rule<R>);
}

}  // namespace

void register_methods() {
  contact::register_method("paper-plane", &make<PaperPlane>);
  contact::register_method("paper-alg1", &make<PaperAlg1>);
  contact::register_method("face-normal", &make<FaceNormal>);
  contact::register_method("approach-velocity", &make<ApproachVelocity>);
}

}  // namespace palpate::collision
