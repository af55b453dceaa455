// Loops of one world: simulations, or cycles of devices.
#pragma once

#include <cstddef>
#include <memory>
#include <stdexcept>
#include <vector>

#include "palpate/loop/instruments.hpp"

namespace palpate::bindings {

/// Puts the instruments of several loops into one world. loops: pointers of any kind.
template <class Loops>
void join_instruments(const Loops& loops, const std::vector<std::vector<loop::ToolCapsule>>& capsules, double stiffness,
                      double damping, const loop::RodOptions& rod) {
  if (loops.size() != capsules.size()) throw std::invalid_argument("capsules: give one list for each loop");
  const auto board = std::make_shared<loop::Board>(static_cast<int>(loops.size()), rod);
  for (std::size_t i = 0; i < loops.size(); ++i) {
    loops[i]->join(board, static_cast<int>(i), capsules[i], {stiffness, damping});
  }
}

}  // namespace palpate::bindings
