// SPDX-License-Identifier: MIT
// Records a session: a take with the sets that were used, the initial clay, and the user's actions
// (app/session/actions.h). Its replay gives the same clay, bit for bit on one device.
#pragma once

#include <fstream>

#include "app/session/actions.h"
#include "app/session/frame_reader.h"
#include "capture/takes/take_writer.h"
#include "engine/clay/document.h"

namespace airclay {

/// Status of a recording.
struct RecorderView {
  bool recording = false;
  std::filesystem::path folder;
  int frames = 0;
  double waited_s = 0;  ///< total wait for a slow disk
};

class SessionRecorder {
 public:
  struct Start {
    std::filesystem::path folder;  ///< new or empty
    Recording* source = nullptr;   ///< null: the mouse hand
    const Rig& rig;
    ActionsHeader head;                    ///< `hand`: right, left, or a file to copy
    const std::vector<FrameSet>& learned;  ///< the sets that the background was learned from
  };
  /// `document` is the initial state; its history is copied, because undo may reach into it. \throw Error if
  /// the folder cannot be created or is not empty.
  SessionRecorder(const Start& start, const Document& document);

  void action(const Action& action);
  /// Logs the action that replaces the clay, with `state`.
  void clay(const ClayState& state, const std::string& name);
  void document(const Document& opened);
  /// Logs a processed frame, with its set if there are cameras. Waits if the disk is slower than the cameras.
  /// \throw Error if the disk is full
  void frame(const ReplayFrame& frame, const FrameSet* set);
  /// Completes the recording. \throw Error if writing failed
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
