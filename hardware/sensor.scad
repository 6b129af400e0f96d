// The whisker sensor: printed parts and moulds, by parameters.
//
// Open with OpenSCAD (2021.01 or later), choose `part`, render, export as STL. All lengths are millimetres.
// hardware/draw reads the same numbers for its drawings, and the tests hold them against `vibrissa sensor design`.
// Nobody has printed these parts yet: print `test_piece` first and see how your printer's holes come out.

// ---- what you may change -------------------------------------------------------------------------------------------
part = "assembly";        // assembly, base, ring, hub, mould_plate, mould_floor, test_piece

whisker_diameter = 0.58;  // Nitinol wire (the paper's)
whisker_length = 75;      // free length, from the middle of the rubber (the paper's)

magnet_diameter = 2;      // neodymium disc, magnetized through its height
magnet_height = 1;
magnet_depth = 3;         // magnet's centre below the middle of the rubber
magnet_to_chip = 5;       // magnet's centre to the chip's sensing element: `vibrissa sensor design --distance "5 mm"`

rubber_diameter = 14;     // free diameter of the rubber disc, inside the clamp
rubber_thickness = 1.8;   // stiffness goes with its cube; 0.05 N m/rad of Shore 50A by plate theory (hardware/draw)
rubber_clamped = 3;       // width of the rim between base and ring
hub_diameter = 4;         // what the rubber is glued to

board_width = 15;         // breakout board of the chip: measure yours
board_length = 20;
board_thickness = 1.6;
chip_height = 1;          // package above the board
element_depth = 0.5;      // sensing element below the top of the package: a guess, calibration takes it up

wall = 2.4;
screw = 2.2;              // M2 screws with clearance, four of them
floor = 2;
fit = 0.15;               // gap between parts that go into each other

// ---- what follows from it ------------------------------------------------------------------------------------------
rim = rubber_diameter / 2 + rubber_clamped;        // radius of the rubber as cast
screw_circle = rim + screw / 2 + 0.8;
outer = screw_circle + screw / 2 + wall;           // radius of base and ring
chip_top = magnet_depth + magnet_to_chip - element_depth;   // below the rubber's middle
board_top = chip_top + chip_height;
shaft = magnet_depth - magnet_height / 2 - rubber_thickness / 2;   // hub below the rubber, above the magnet
body = board_top + board_thickness + 4;            // base, from the rubber's middle to the floor's top

$fn = 72;

module screws(height) {
    // Beside the board's drawer.
    for (a = [35, 145, 215, 325]) rotate(a) translate([screw_circle, 0, 0]) cylinder(d = screw, h = height);
}

// Holds the rubber's rim and the board. The chip looks up through its middle; its first axis points away from the notch.
module base() {
    difference() {
        translate([0, 0, -body - floor]) cylinder(r = outer, h = body + floor);
        // Half of the rim's thickness sinks into the base.
        translate([0, 0, -rubber_thickness / 2]) cylinder(r = rim + fit, h = rubber_thickness);
        // The room in which the magnet swings.
        translate([0, 0, -board_top - board_thickness - 0.01]) cylinder(d = rubber_diameter, h = 2 * body);
        // A drawer for the board, open to one side.
        translate([-board_width / 2 - fit, -board_length / 2 - fit, -board_top - board_thickness])
            cube([board_width + 2 * fit, outer + board_length, board_thickness + 2 * fit]);
        // Room below it for pins and wires.
        translate([-board_width / 2 + 1.5, -board_length / 2 + 1.5, -body])
            cube([board_width - 3, outer + board_length, 4]);
        translate([0, 0, -body - floor - 1]) screws(body + floor + 2);
        // The notch says where +y is: the whisker's left.
        translate([0, outer, -3]) cylinder(d = 2, h = 4);
    }
}

// Clamps the rim from above.
module ring() {
    difference() {
        cylinder(r = outer, h = rubber_thickness / 2 + wall);
        translate([0, 0, -0.01]) cylinder(r = rim + fit, h = rubber_thickness / 2);
        translate([0, 0, -1]) cylinder(d = rubber_diameter, h = 20);
        translate([0, 0, -1]) screws(20);
        translate([0, outer, -1]) cylinder(d = 2, h = 20);
    }
}

// Goes through the rubber: the whisker above, the magnet below.
module hub() {
    flange = 0.6;
    difference() {
        union() {
            translate([0, 0, -magnet_depth + magnet_height / 2]) cylinder(d = hub_diameter, h = magnet_depth - magnet_height / 2 + rubber_thickness / 2);
            translate([0, 0, rubber_thickness / 2]) cylinder(d = hub_diameter + 2, h = flange);
            translate([0, 0, -magnet_depth - magnet_height / 2]) cylinder(d = magnet_diameter + 2 * 0.6, h = magnet_height + shaft);
        }
        // The wire's hole ends above the magnet. Above the rubber's middle the wire is free, so that it bends from there on, where it turns.
        translate([0, 0, -magnet_depth + magnet_height / 2 + 0.4]) cylinder(d = whisker_diameter + 0.1, h = 20);
        cylinder(d1 = whisker_diameter + 0.1, d2 = whisker_diameter + 1.6, h = rubber_thickness / 2 + flange + 0.01);
        translate([0, 0, -magnet_depth - magnet_height / 2 - 0.01]) cylinder(d = magnet_diameter + 0.1, h = magnet_height + 0.01);
    }
}

// Acrylic: as thick as the rubber, with the rubber's shape cut out. Between two floors it is the mould.
module mould_plate() {
    difference() {
        translate([-rim - 8, -rim - 8, 0]) cube([2 * rim + 16, 2 * rim + 16, rubber_thickness]);
        translate([0, 0, -1]) cylinder(r = rim, h = rubber_thickness + 2);
        for (x = [-1, 1], y = [-1, 1]) translate([x * (rim + 4.5), y * (rim + 4.5), -1]) cylinder(d = screw, h = 20);
    }
}

// The lower floor carries a pin as wide as the hub; print it, or glue a turned pin into an acrylic plate.
module mould_floor() {
    difference() {
        union() {
            translate([-rim - 8, -rim - 8, -3]) cube([2 * rim + 16, 2 * rim + 16, 3]);
            cylinder(d = hub_diameter, h = rubber_thickness);
        }
        for (x = [-1, 1], y = [-1, 1]) translate([x * (rim + 4.5), y * (rim + 4.5), -5]) cylinder(d = screw, h = 20);
    }
}

// Holes of wire, magnet, hub and screw, to see what the printer makes of them.
module test_piece() {
    difference() {
        cube([30, 10, 3]);
        for (k = [0 : 3]) translate([4 + 7 * k, 5, -1])
            cylinder(d = [whisker_diameter + 0.1, magnet_diameter + 0.1, hub_diameter, screw][k], h = 20);
    }
}

module assembly() {
    color("gainsboro") difference() { base(); translate([0, -100, -100]) cube([200, 200, 200]); }
    color("silver") difference() { ring(); translate([0, -100, -100]) cube([200, 200, 200]); }
    color("tomato") translate([0, 0, -rubber_thickness / 2]) difference() {
        cylinder(r = rim, h = rubber_thickness);
        translate([0, 0, -1]) cylinder(d = hub_diameter, h = 20);
    }
    color("white") hub();
    color("gray") translate([0, 0, -magnet_depth + magnet_height / 2 + 0.4])
        cylinder(d = whisker_diameter, h = whisker_length + magnet_depth - magnet_height / 2 - 0.4);
    color("black") translate([0, 0, -magnet_depth - magnet_height / 2]) cylinder(d = magnet_diameter, h = magnet_height);
    color("green") translate([-board_width / 2, -board_length / 2, -board_top - board_thickness]) cube([board_width, board_length, board_thickness]);
    color("dimgray") translate([-1.5, -1.5, -board_top]) cube([3, 3, chip_height]);
}

if (part == "base") base();
else if (part == "ring") ring();
else if (part == "hub") hub();
else if (part == "mould_plate") mould_plate();
else if (part == "mould_floor") mould_floor();
else if (part == "test_piece") test_piece();
else assembly();
