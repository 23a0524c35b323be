"""What the windIO files lack, per reference turbine, with the source of every figure.

Read by ``make_turbines.py``.  ElastoDyn files are those of the turbines' public repositories
(github.com/IEAWindTask37), in the version whose geometry is that of the windIO file.
"""

REPORT_5 = "Jonkman et al. (2009), NREL/TP-500-38060"
REPORT_3_10 = "Bortolotti et al. (2019), IEA Wind Task 37, NREL/TP-73492"
REPORT_15 = "Gaertner et al. (2020), NREL/TP-5000-75698"
REPORT_22 = "Zahle et al. (2024), DTU Wind Report E-0243"
WINDIO = "windIO v2 file {file} of WISDEM 4.2.9 (github.com/WISDEM/WISDEM, Apache-2.0)"
TUNING = "rated wind speed: speed at which the tuning table of the windIO file changes its step"

EXTRAS = {
    "iea-3.4-130": {
        "file": "IEA-3p4-130-RWT.yaml",
        "report": REPORT_3_10,
        "description": "IEA Wind Task 37 3.4 MW land-based reference turbine, 130 m rotor, "
        "geared, class IIIA.",
        "operation": {"rated_wind_speed": 9.8, "torque_rate": 1500.0, "max_tip_speed": 80.0},
        "hub": {"mass": 27975.0, "inertia": 60131.0},
        "nacelle": {
            "mass": 190612.0,
            "yaw_inertia": 1210200.0,
            "centre": [0.0995, 0.0, 0.5843],
            "yaw_bearing_mass": 0.0,
        },
        "drivetrain": {
            "gear_ratio": 97.0,
            "efficiency": 0.936,
            "generator_inertia": 500.0,
            "torsion_stiffness": 8.67637e8,
            "torsion_damping": 6.215e6,
        },
        "damping": (0.01, 0.01),
        "notes": {
            "hub, nacelle, drivetrain": "IEAWindTask37/IEA-3.4-130-RWT, fast_v8/ElastoDyn.dat",
            "drivetrain.efficiency": "assumed: gearbox 0.955 (ElastoDyn) times generator 0.98",
            "drivetrain.torsion": "the file repeats the figures of the NREL 5 MW",
            "blade_structure": "IEAWindTask37/IEA-3.4-130-RWT, fast_v8/ElastoDyn_Blade.dat; "
            "twist of the first three (circular) stations without 90 degrees",
            "tower": "mass and stiffness: fast_v8/ElastoDyn_Tower.dat, without outfitting; "
            "diameter: windIO file; thickness: derived from mass, diameter and density",
            "operation.rated_wind_speed": "windIO plant example IEA37_3.35MW_turbine.yaml",
            "operation.torque_rate": "control.max_torque_rate of the windIO file",
        },
    },
    "iea-10-198": {
        "file": "IEA-10-198-RWT.yaml",
        "report": REPORT_3_10,
        "description": "IEA Wind Task 37 10 MW offshore reference turbine, 198 m rotor, direct "
        "drive, class IA.",
        "operation": {},
        "hub": {"mass": 81707.0, "inertia": 476512.0},
        "nacelle": {
            "mass": 545623.0,
            "yaw_inertia": 19006380.6,
            "centre": [-5.898043, -0.083102, 2.530334],
            "yaw_bearing_mass": 93457.0,
        },
        "drivetrain": {
            "gear_ratio": 1.0,
            "efficiency": 0.944,
            "generator_inertia": 3801700.0,
            "torsion_stiffness": 2.317025e9,
            "torsion_damping": 9.24056e6,
        },
        "damping": (None, None),
        "notes": {
            "hub, nacelle, drivetrain": "IEAWindTask37/IEA-10.0-198-RWT, "
            "openfast/IEA-10.0-198-RWT_ElastoDyn.dat; efficiency: windIO file",
            "operation.rated_wind_speed": "not given: the tuning table of the windIO file says "
            "10 m/s, which would take a power coefficient of 0.56",
            "operation.torque_rate": "not given: the windIO file's value has no clear unit",
        },
    },
    "iea-15-240": {
        "file": "IEA-15-240-RWT.yaml",
        "report": REPORT_15,
        "description": "IEA Wind 15 MW offshore reference turbine, fixed bottom, 240 m rotor, "
        "direct drive, class IB.",
        "operation": {"rated_wind_speed": 10.59, "torque_rate": 4.5e6},
        "hub": {"mass": 69360.0, "inertia": 973520.0},
        "nacelle": {
            "mass": 646895.0,
            "yaw_inertia": 24240914.0,
            "centre": [-4.72, 0.0, 4.275],
            "yaw_bearing_mass": 28280.0,
        },
        "drivetrain": {
            "gear_ratio": 1.0,
            "efficiency": 0.95756,
            "generator_inertia": 1836784.0,
            "torsion_stiffness": 5.114093961e10,
            "torsion_damping": 4.2676833e7,
        },
        "damping": (None, None),
        "notes": {
            "hub, nacelle, drivetrain": "IEAWindTask37/IEA-15-240-RWT, OpenFAST/"
            "IEA-15-240-RWT-Monopile/IEA-15-240-RWT-Monopile_ElastoDyn.dat, release with "
            "hub radius 3.97 m; differs from the report's first release (hub 190 t)",
            "drivetrain.efficiency": "derived: the largest generator torque of the windIO file "
            "taken as 1.1 times rated torque",
            "operation.rated_wind_speed": TUNING,
            "operation.torque_rate": "control.max_torque_rate of the windIO file",
        },
    },
    "iea-22-280": {
        "file": "IEA-22-280-RWT.yaml",
        "report": REPORT_22,
        "description": "IEA Wind 22 MW offshore reference turbine, fixed bottom, 284 m rotor, "
        "direct drive, class IB.",
        "operation": {"rated_wind_speed": 10.9273, "torque_rate": 4.5e6},
        "hub": {"mass": 120447.702, "inertia": 1882498.883},
        "nacelle": {
            "mass": 821239.8,
            "yaw_inertia": 52470672.3,
            "centre": [-5.847043, -0.166531, 4.26479],
            "yaw_bearing_mass": 28740.99,
        },
        "drivetrain": {
            "gear_ratio": 1.0,
            "efficiency": 0.953,
            "generator_inertia": 3117597.54,
            "torsion_stiffness": 1.0e12,
            "torsion_damping": 1.0e9,
        },
        "damping": (None, None),
        "notes": {
            "hub, nacelle, drivetrain": "IEAWindTask37/IEA-22-280-RWT, OpenFAST/"
            "IEA-22-280-RWT-Monopile/IEA-22-280-RWT_ElastoDyn.dat; efficiency: ..._ServoDyn.dat; "
            "torsion there is a nearly rigid shaft",
            "blade_structure": "every second of the windIO file's 102 stations, and the tip",
            "operation.rated_wind_speed": TUNING,
            "operation.torque_rate": "control.max_torque_rate of the windIO file",
        },
    },
}

NREL_5 = {
    "file": "nrel5mw.yaml",
    "description": "NREL 5 MW reference turbine as OpenFAST's regression tests define it, on land.",
    "rotor": {
        "blades": 3,
        "hub_radius": 1.5,
        "hub_height": 90.0,
        "overhang": 5.0191,
        "tilt_deg": 5.0,
        "cone_deg": 2.5,
    },
    "operation": {
        "rated_power": 5.0e6,
        "rated_rotor_speed_rpm": 12.1,
        "min_rotor_speed_rpm": 6.9,
        "max_tip_speed": 80.0,
        "rated_wind_speed": 11.4,
        "cut_in_wind_speed": 3.0,
        "cut_out_wind_speed": 25.0,
        "optimal_tip_speed_ratio": 7.56,
        "fine_pitch_deg": 0.0,
        "pitch_range_deg": [0.0, 90.0],
        "pitch_rate_deg": 8.0,
        "torque_rate": 15000.0,
        "iec_class": "IB",
    },
    "hub": {"mass": 56780.0, "inertia": 115926.0},
    "nacelle": {
        "mass": 240000.0,
        "yaw_inertia": 2607890.0,
        "centre": [1.9, 0.0, 1.75],
        "yaw_bearing_mass": 0.0,
    },
    "drivetrain": {
        "gear_ratio": 97.0,
        "efficiency": 0.944,
        "generator_inertia": 534.116,
        "torsion_stiffness": 8.67637e8,
        "torsion_damping": 6.215e6,
    },
    "notes": {
        "blade": "OpenFAST/r-test, 5MW_Baseline/NRELOffshrBsline5MW_AeroDyn_blade.dat: "
        "AeroDyn's 19 stations, tip at 61.4999 m",
        "airfoils": "OpenFAST/r-test, 5MW_Baseline/Airfoils/*.dat (the windIO file of this turbine "
        "carries smoothed tables, which differ by up to 0.08 in attached lift)",
        "blade_structure": "OpenFAST/r-test, 5MW_Baseline/NRELOffshrBsline5MW_Blade.dat, mass "
        "times its factor 1.04536; torsion stiffness: windIO file of WISDEM 4.2.9. Integrated "
        "linearly the blade has 17 609 kg, ElastoDyn's 17 sections make 17 537 kg of it",
        "tower": "derived: 6 m by 35.1 mm at the base to 3.87 m by 24.7 mm at the top, linear, "
        "for mass and stiffness, which makes the known 347 460 kg; the outer diameter is "
        "AeroDyn's, which reaches 3.87 m at 85.268 m",
        "operation": "speeds and wind speeds: windIO file of WISDEM 4.2.9; pitch and torque rate: "
        "limits of the baseline controller of OpenFAST/r-test",
        "operation.optimal_tip_speed_ratio": "derived from that controller's torque gain of "
        "2.332287 N m/(rad/s)^2 with a power coefficient of 0.482",
        "hub, nacelle, drivetrain": "OpenFAST/r-test, 5MW_Land_DLL_WTurb ElastoDyn file",
    },
}

BIEGEL_2011 = {
    "format": "pitchopt-turbine-1",
    "name": "biegel2011",
    "source": "Biegel, Juelsgaard, Kraning, Boyd, Stoustrup (2011), Wind turbine pitch "
    "optimization; airfoil of the NREL 5 MW (NREL/TP-500-38060)",
    "description": "The static rotor of the paper: three blades of constant chord, two elements "
    "each, no tilt, no cone. What the paper leaves open is set as the notes say.",
    "rotor": {
        "blades": 3,
        "hub_radius": 8.0,
        "hub_height": 80.0,
        "overhang": 5.5,
        "tilt_deg": 0.0,
        "cone_deg": 0.0,
    },
    "operation": {
        "rated_power": 2.82e6,
        "rated_rotor_speed_rpm": 19.098593171027442,
        "min_rotor_speed_rpm": 19.098593171027442,
        "pitch_range_deg": [-10.0, 45.0],
        "pitch_rate_deg": 10.0,
        "alpha_min_deg": -5.0,
        "air_density": 1.225,
    },
    "blade": {
        "elements": 2,
        "root_radius": 8.0,
        "tip_radius": 40.0,
        "chord": 0.957361846,
        "design_wind_speed": 15.0,
        "design_rotor_speed": 2.0,
    },
    "tower": {"height": [0.0, 80.0], "diameter": [1.93470519, 1.93470519]},
    "notes": {
        "rotor": "R = 40 m and hub height 80 m: paper; root at 8 m and overhang 5.5 m: assumed",
        "operation": "2 rad/s and 10 deg/s: assumed. Pitch range: wide on purpose, the angle of "
        "attack (from -5 degrees to stall) is what limits. Rated power: derived, 1.41e6 N m of "
        "the best constant pitch times 2 rad/s",
        "blade.twist": "derived: atan(15/(2 r)) - atan(15/(2 R)) at each element's centre",
        "blade.chord, tower.diameter": "calibrated so that the best constant pitch has the "
        "paper's mean torque 1.41e6 N m and summed RMS 3.2e4 (tools/calibrate_biegel.py)",
        "airfoils": "NACA 64-618 of the NREL 5 MW as WISDEM 4.2.9 has it in nrel5mw.yaml: the "
        "table of NREL/TP-500-38060 smoothed, which is nearly concave up to stall",
    },
}
