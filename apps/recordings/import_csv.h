/// @file
/// A folder of CSV files, one per sensor.
#pragma once

#include <filesystem>

#include "apps/recordings/import.h"

namespace leadline::app {

/// Reads what is there of these files. Each has a header line, then rows in the order of time; times are
/// seconds since any epoch, all else SI units and radians. Other files are ignored.
///
/// | file              | columns            | remarks                                       |
/// |-------------------|--------------------|-----------------------------------------------|
/// | heading.csv       | t,heading,sigma    | empty sigma: as configured                    |
/// | speed.csv         | t,speed,sigma      | likewise                                      |
/// | body_velocity.csv | t,surge,sway,      | velocity over ground in the body frame;       |
/// |                   | surge_sigma,       | sigmas likewise                               |
/// |                   | sway_sigma         |                                               |
/// | yaw_rate.csv      | t,yaw_rate,sigma   | of a gyro; sigma likewise                     |
/// | velocity.csv      | t,v,omega          | held until the next row                       |
/// | ackermann.csv     | t,v,steering       | likewise                                      |
/// | odometry.csv      | t,dx,dy,dheading   | since the previous row, in the body frame     |
/// |                   |                    | at that time                                  |
/// | range_sonar.csv   | t,channel,range    | channel: name of the sensor; empty range: a   |
/// |                   |                    | ping without echo. Columns that may follow:   |
/// |                   |                    | sigma (empty: as configured), confidence (0   |
/// |                   |                    | to 1; empty: unknown), label (empty: unknown) |
/// | range_bearing.csv | t,range,bearing,id | empty id: unknown; empty range: a scan that   |
/// |                   |                    | saw nothing                                   |
/// | truth.csv         | t,x,y,heading      | empty heading: unknown                        |
/// | landmarks.csv     | id,x,y             | true points                                   |
///
/// Rows of range_sonar.csv and range_bearing.csv with equal times are one scan. Something tells how the
/// vehicle moves: one of velocity, ackermann and odometry, or speed, body_velocity, or what is seen from it.
/// Sensors are the channels of range_sonar.csv in the order in which they appear, then one named
/// "range_bearing" if there is such a file.
/// @throws std::runtime_error naming file, line, column, value and what is allowed.
Import import_csv(const std::filesystem::path& folder);

}  // namespace leadline::app
