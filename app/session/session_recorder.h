// SPDX-License-Identifier: MIT
// Records what a session does: a take with the sets that were used, the clay at the start, and what the
// person did (app/session/actions.h). Played again it makes the same clay, bit for bit on one device.
#pragma once

#include <fstream>

#include "app/session/actions.h"
#include "app/session/frame_reader.h"
#include "capture/takes/take_writer.h"
#include "engine/clay/document.h"

namespace airclay {

/// How a recording goes, for the status.
struct RecorderView {
  bool recording = false;
  std::filesystem::path folder;
  int frames = 0;
  double waited_s = 0;  ///< what the work has waited for a slow disk
};

class SessionRecorder {
 public:
  struct Start {
    std::filesystem::path folder;  ///< a new or empty one
    Recording* source = nullptr;   ///< none: the mouse's hand
    const Rig& rig;
    ActionsHeader head;                    ///< `hand` right, left, or a file to be copied
    const std::vector<FrameSet>& learned;  ///< the sets that taught the empty workspace so far
  };
  /// `document` is where the recording begins; its history goes along, as undo may reach back.
  /// \throw Error when the folder cannot be made or is not empty.
  SessionRecorder(const Start& start, const Document& document);

  void action(const Action& action);
  /// The deed that brings a clay from elsewhere: `state` goes along.
  void clay(const ClayState& state, const std::string& name);
  void document(const Document& opened);
  /// A frame as it was worked on, and its set, where there are cameras. Waits for a disk that is slower than
  /// the cameras. \throw Error when the disk is full
  void frame(const ReplayFrame& frame, const FrameSet* set);
  /// Ends it as it should. \throw Error when something could not be written
  void end();

  RecorderView view() const;

 private:
  void write(const std::string& lines);
  std::filesystem::path nextFile();

  std::filesystem::path folder_;
  bool by_mouse_;
  TakeWriter take_;
  std::ofstream actions_;
  int frames_ = 0, files_ = 0;
};

}  // namespace airclay
