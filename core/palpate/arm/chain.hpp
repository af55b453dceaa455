// A serial arm as numbers: a chain of revolute and prismatic joints, each moving one rigid link.
#pragma once

#include <string>
#include <vector>

#include "palpate/arm/mechanism.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::arm {

/// One joint and the link that it moves. The link's axes are the joint's; at q = 0 the joint adds no motion.
struct Link {
  Pose X_parent;  ///< joint in the previous link's axes, at q = 0
  Vec3 axis = Vec3::UnitZ();
  bool prismatic = false;
  double mass = 0.0;            ///< [kg]
  Vec3 com = Vec3::Zero();      ///< centre of mass in the link's axes [m]
  Mat3 inertia = Mat3::Zero();  ///< about the centre of mass, in the link's axes [kg m^2]
};

/// A frame that is fixed to a link.
struct FixedFrame {
  int link = -1;  ///< index of the link; -1: the base
  Pose X_link;
};

struct Chain {
  std::vector<Link> links;  ///< from base to tip
  FixedFrame tip;
  std::vector<FixedFrame> frames;  ///< of facts.link_names
  Facts facts;
};

/// The chain between two links of a URDF; all other joints are locked at zero and their masses added to the link that
/// carries them. Throws std::runtime_error naming the frame or joint that does not fit, and the remedy.
[[nodiscard]] Chain chain_from_urdf(const std::string& xml, const std::string& base_frame,
                                    const std::string& tip_frame);

}  // namespace palpate::arm
