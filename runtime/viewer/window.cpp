#include "runtime/viewer/window.h"

#include "runtime/base/error.h"

namespace beatlas::viewer {

int show_window(const ViewOptions&, const std::optional<OpenedHeart>&) {
  throw Error(ErrorCode::Usage, "the window is not built; use --screenshot FILE");
}

}  // namespace beatlas::viewer
