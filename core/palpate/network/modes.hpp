// What crosses the network between hand and remote tool.
#pragma once

namespace palpate::network {

/// Section `remote`, key `mode`.
enum class Mode {
  model,      ///< the hand feels a local model whose parameters come over the network
  passivity,  ///< the hand feels the measured force, as far as the energies of both ports allow
  direct,     ///< the hand feels the measured force: unstable with delay, for comparisons
};

/// What both ends have alike.
struct EndOptions {
  Mode mode = Mode::model;
  double radius = 0.002;  ///< radius of the tool's sphere [m]
  bool planes = false;    ///< mode model: surfaces that the scene does not have are felt as planes
  double drag = 1.0;      ///< mode passivity: damping of the hand, whose energy the far tool may spend [N s/m]
};

}  // namespace palpate::network
