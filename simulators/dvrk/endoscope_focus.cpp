#include "dvrk/endoscope_focus.hpp"

namespace palpate::dvrk {

void EndoscopeFocus::start() noexcept {
  publisher_.flag(Topic::locked, false);
  publisher_.flag(Topic::focusing_in, false);
  publisher_.flag(Topic::focusing_out, false);
}

bool EndoscopeFocus::apply(const Command& c) noexcept {
  switch (c.verb) {
    case Verb::focus_lock:
      lock(c.flag);
      return true;
    case Verb::focus_in:
      focus_in(c.flag);
      return true;
    case Verb::focus_out:
      focus_out(c.flag);
      return true;
    default:
      return false;
  }
}

void EndoscopeFocus::lock(bool on) noexcept {
  if (on) {
    focus_in(false);
    focus_out(false);
  }
  locked_ = on;
  publisher_.flag(Topic::locked, on);
}

void EndoscopeFocus::focus(bool& mine, bool other, Topic topic, bool on) noexcept {
  if (locked_ || mine == on || (on && other)) return;
  mine = on;
  publisher_.flag(topic, on);
}

}  // namespace palpate::dvrk
