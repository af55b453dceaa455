// Method `proxy` (the default): a sphere that stays outside while the tool goes in, one for each object
// (object_proxy.hpp for meshes, field_proxy.hpp for all other surfaces); here the objects' frames, friction and what
// moves.
//
// Friction (Coulomb): the proxy lags behind on the tangent plane, at most mu times the normal deflection.
#pragma once

#include <array>

#include "palpate/contact/contact.hpp"
#include "palpate/contact/field_proxy.hpp"
#include "palpate/contact/object_proxy.hpp"

namespace palpate::contact {

/// Objects with a proxy of their own; further objects of a snapshot are not touched.
inline constexpr int kMaxObjects = 32;

class Proxy final : public Method {
 public:
  explicit Proxy(const Options& options) : options_(options) {}
  void reset() noexcept override;
  const ContactSet& step(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT, double t) noexcept override;

 private:
  /// What friction and surface velocity need to remember of an object.
  struct Memory {
    ObjectProxy proxy;  // on a mesh
    FieldProxy field;   // on any other surface
    bool touching = false;
    bool seen = false;          // X_WO is of the previous tick
    Vec3 p_lag = Vec3::Zero();  // p_OP, the proxy with friction
    Pose X_WO;
  };

  void touch(const scene::Object& object, int index, Memory& memory, const Vec3& p_OT, double dt) noexcept;

  Options options_;
  std::array<Memory, kMaxObjects> memory_;
  ContactSet set_;
  double t_ = 0.0;
  bool running_ = false;
};

}  // namespace palpate::contact
