#!/usr/bin/env python3
"""storeys_ifc.py STOREYS OUT.ifc - an IFC4 building of equal storeys, each with twelve rooms along a corridor.

Each storey has walls with openings, doors with leaves, windows with glass, spaces with names, slabs, columns and tables that are mapped
from one shape, and sets of properties. `storeys_ifc.py 1 small.ifc` is a sample; with 12,200 storeys the file has a gibibyte, for measurements.
"""
import sys

ROOM, DEPTH, CORRIDOR, WALL, HIGH, SLAB = 4000, 5000, 2000, 200, 2800, 300  # millimetres
ROOMS = 6  # on each side of the corridor

HEAD = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION(('ViewDefinition [ReferenceView]'),'2;1');
FILE_NAME('storeys.ifc','2026-11-26T12:00:00',(''),(''),'storeys_ifc.py','Enfilade','');
FILE_SCHEMA(('IFC4'));
ENDSEC;
DATA;
#1=IFCSIUNIT(*,.LENGTHUNIT.,.MILLI.,.METRE.);
#2=IFCSIUNIT(*,.PLANEANGLEUNIT.,$,.RADIAN.);
#3=IFCUNITASSIGNMENT((#1,#2));
#4=IFCCARTESIANPOINT((0.,0.,0.));
#5=IFCAXIS2PLACEMENT3D(#4,$,$);
#6=IFCDIRECTION((0.,1.));
#7=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-05,#5,#6);
#8=IFCPROJECT('0000000000000000000001',$,'Storeys',$,$,$,$,(#7),#3);
#9=IFCLOCALPLACEMENT($,#5);
#10=IFCSITE('0000000000000000000002',$,'Site',$,$,#9,$,$,.ELEMENT.,(52,31,0),(13,24,0),0.,$,$);
#11=IFCBUILDING('0000000000000000000003',$,'Storeys',$,$,#9,$,$,.ELEMENT.,$,$,$);
#12=IFCRELAGGREGATES('0000000000000000000004',$,$,$,#8,(#10));
#13=IFCRELAGGREGATES('0000000000000000000005',$,$,$,#10,(#11));
#14=IFCDIRECTION((0.,0.,1.));
#15=IFCDIRECTION((0.,1.,0.));
#16=IFCCARTESIANPOINTLIST3D(((-700.,-400.,700.),(700.,-400.,700.),(700.,400.,700.),(-700.,400.,700.),(-700.,-400.,740.),(700.,-400.,740.),(700.,400.,740.),(-700.,400.,740.)));
#17=IFCINDEXEDPOLYGONALFACE((1,4,3,2));
#18=IFCINDEXEDPOLYGONALFACE((5,6,7,8));
#19=IFCINDEXEDPOLYGONALFACE((1,2,6,5));
#20=IFCINDEXEDPOLYGONALFACE((2,3,7,6));
#21=IFCINDEXEDPOLYGONALFACE((3,4,8,7));
#22=IFCINDEXEDPOLYGONALFACE((4,1,5,8));
#23=IFCPOLYGONALFACESET(#16,.T.,(#17,#18,#19,#20,#21,#22),$);
#24=IFCRECTANGLEPROFILEDEF(.AREA.,$,$,60.,60.);
#25=IFCEXTRUDEDAREASOLID(#24,$,#14,700.);
#26=IFCSHAPEREPRESENTATION(#7,'Body','SolidModel',(#23,#25));
#27=IFCREPRESENTATIONMAP(#5,#26);
#28=IFCCARTESIANTRANSFORMATIONOPERATOR3D($,$,#4,1.,$);
#30=IFCCOLOURRGB($,0.93,0.91,0.86);
#31=IFCSURFACESTYLERENDERING(#30,0.,$,$,$,$,$,$,.FLAT.);
#32=IFCSURFACESTYLE('Plaster',.BOTH.,(#31));
#33=IFCMATERIAL('Plaster',$,$);
#34=IFCSTYLEDITEM($,(#32),$);
#35=IFCSTYLEDREPRESENTATION(#7,'Style','Material',(#34));
#36=IFCMATERIALDEFINITIONREPRESENTATION($,$,(#35),#33);
#37=IFCCOLOURRGB($,0.7,0.8,0.85);
#38=IFCSURFACESTYLERENDERING(#37,0.75,$,$,$,$,$,$,.FLAT.);
#39=IFCSURFACESTYLE('Glass',.BOTH.,(#38));
#40=IFCCOLOURRGB($,0.45,0.3,0.18);
#41=IFCSURFACESTYLERENDERING(#40,0.,$,$,$,$,$,$,.FLAT.);
#42=IFCSURFACESTYLE('Wood',.BOTH.,(#41));
#43=IFCSTYLEDITEM(#23,(#42),$);
#44=IFCCIRCLEPROFILEDEF(.AREA.,$,$,150.);
"""

CODE = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_$"


class Storey:
    """The lines of one storey; numbers and GlobalIds are filled in later, from `first`."""

    def __init__(self):
        self.lines, self.count, self.products, self.spaces, self.walls = [], 0, [], [], []

    def add(self, text):
        self.lines.append((self.count, text))
        self.count += 1
        return f"\x01{self.count - 1}\x02"

    def guid(self):
        return "'\x03'"

    def place(self, x, y, z, base, turned=False):
        point = self.add(f"IFCCARTESIANPOINT(({x:.0f}.,{y:.0f}.,{z:.0f}.))")
        axes = self.add(f"IFCAXIS2PLACEMENT3D({point},#14,{'#15' if turned else '$'})")
        return self.add(f"IFCLOCALPLACEMENT({base},{axes})")

    def box(self, x, y, z, style=None):
        """A body of the size x, y, z that begins at x = 0 and z = 0, and lies about y = 0."""
        point = self.add(f"IFCCARTESIANPOINT(({x / 2:.1f},0.))")
        axes = self.add(f"IFCAXIS2PLACEMENT2D({point},$)")
        profile = self.add(f"IFCRECTANGLEPROFILEDEF(.AREA.,$,{axes},{x:.0f}.,{y:.0f}.)")
        return self.body(self.add(f"IFCEXTRUDEDAREASOLID({profile},$,#14,{z:.0f}.)"), style=style)

    def body(self, item, kind="SweptSolid", style=None):
        if style:
            self.add(f"IFCSTYLEDITEM({item},({style}),$)")
        shape = self.add(f"IFCSHAPEREPRESENTATION(#7,'Body','{kind}',({item}))")
        return self.add(f"IFCPRODUCTDEFINITIONSHAPE($,$,({shape}))")

    def hole(self, wall, base, at, wide, high, sill, kind):
        """A door or a window at `at` along a wall."""
        place = self.place(at, 0, sill, base)
        opening = self.add(f"IFCOPENINGELEMENT({self.guid()},$,'Opening',$,$,{place},{self.box(wide, WALL + 40, high)},$,.OPENING.)")
        self.add(f"IFCRELVOIDSELEMENT({self.guid()},$,$,$,{wall},{opening})")
        inner = self.place(0, 0, 0, place)
        if kind == "door":
            body = self.box(wide, 50, high, "#42")
            filling = self.add(f"IFCDOOR({self.guid()},$,'Door',$,$,{inner},{body},$,{high}.,{wide}.,.DOOR.,.SINGLE_SWING_LEFT.,$)")
        else:
            body = self.box(wide, 30, high, "#39")
            filling = self.add(f"IFCWINDOW({self.guid()},$,'Window',$,$,{inner},{body},$,{high}.,{wide}.,.WINDOW.,$,$)")
        self.add(f"IFCRELFILLSELEMENT({self.guid()},$,$,$,{opening},{filling})")
        self.products.append(filling)
        self.properties(filling, f"Pset_{kind.title()}Common", (("Reference", f"IFCIDENTIFIER('{wide} x {high}')"), ("FireRating", "IFCLABEL('T30')"),
                                                                ("IsExternal", "IFCBOOLEAN(.F.)"), ("ThermalTransmittance", "IFCTHERMALTRANSMITTANCEMEASURE(1.3)")))

    def properties(self, of, name, pairs):
        """A set of properties, as programs write one for each product."""
        values = [self.add(f"IFCPROPERTYSINGLEVALUE('{key}',$,{value},$)") for key, value in pairs]
        kept = self.add(f"IFCPROPERTYSET({self.guid()},$,'{name}',$,({','.join(values)}))")
        self.add(f"IFCRELDEFINESBYPROPERTIES({self.guid()},$,$,$,({of}),{kept})")

    def wall(self, base, x, y, length, turned, holes):
        place = self.place(x, y, 0, base, turned)
        wall = self.add(f"IFCWALL({self.guid()},$,'Wall',$,$,{place},{self.box(length, WALL, HIGH)},$,.STANDARD.)")
        self.products.append(wall)
        self.walls.append(wall)
        self.properties(wall, "Pset_WallCommon", (("Reference", "IFCIDENTIFIER('Plastered 200')"), ("LoadBearing", "IFCBOOLEAN(.T.)"),
                                                  ("IsExternal", "IFCBOOLEAN(.F.)"), ("FireRating", "IFCLABEL('F90')"), ("AcousticRating", "IFCLABEL('52 dB')")))
        for hole in holes:
            self.hole(wall, place, *hole)

    def space(self, base, name, x, y, wide, deep):
        place = self.place(x, y + deep / 2, 0, base)
        self.spaces.append(self.add(f"IFCSPACE({self.guid()},$,'{name[0]}',$,$,{place},{self.box(wide, deep, HIGH)},'{name[1]}',.ELEMENT.,.INTERNAL.,$)"))
        self.properties(self.spaces[-1], "Pset_SpaceCommon", (("Reference", "IFCIDENTIFIER('Office')"), ("GrossPlannedArea", f"IFCAREAMEASURE({wide * deep / 1e6:.2f})"),
                                                              ("PubliclyAccessible", "IFCBOOLEAN(.F.)"), ("HandicapAccessible", "IFCBOOLEAN(.T.)")))


def make_storey():
    s = Storey()
    storey_place = s.add("IFCLOCALPLACEMENT(#9,\x04)")
    long, deep = ROOMS * ROOM, 2 * DEPTH + CORRIDOR
    for side in range(2):
        y = deep if side else 0
        windows = [(i * ROOM + 1200, 1600, 1400, 900, "window") for i in range(ROOMS)]
        s.wall(storey_place, -WALL / 2, y, long + WALL, False, windows)
        doors = [(i * ROOM + 400 + 150 * (i % 3), 900, 2100, 0, "door") for i in range(ROOMS)]
        s.wall(storey_place, 0, DEPTH + side * CORRIDOR, long, False, doors)
        for i in range(1, ROOMS):
            s.wall(storey_place, i * ROOM, side * (DEPTH + CORRIDOR) + WALL / 2, DEPTH - WALL, True, [])
        for i in range(ROOMS):
            number = side * ROOMS + i + 1
            x, y = i * ROOM + WALL / 2, side * (DEPTH + CORRIDOR) + WALL / 2
            s.space(storey_place, (f"\x05{number:02d}", f"B\\X2\\00FC\\X0\\ro {number}"), x, y, ROOM - WALL, DEPTH - WALL)
            table = s.add("IFCMAPPEDITEM(#27,#28)")
            place = s.place(x + 1900, y + 2500, 0, storey_place)
            s.products.append(s.add(f"IFCFURNITURE({s.guid()},$,'Table',$,$,{place},{s.body(table, 'MappedRepresentation')},$,.TABLE.)"))
    for x in (0, long):
        s.wall(storey_place, x, WALL / 2, deep - WALL, True, [(DEPTH + 500, 1000, 2100, 0, "door")])
    s.space(storey_place, ("\x0500", "Corridor"), WALL / 2, DEPTH + WALL / 2, long - WALL, CORRIDOR - WALL)
    for i in range(1, ROOMS, 2):
        column = s.add(f"IFCEXTRUDEDAREASOLID(#44,$,#14,{HIGH}.)")
        place = s.place(i * ROOM, DEPTH + CORRIDOR / 2, 0, storey_place)
        s.products.append(s.add(f"IFCCOLUMN({s.guid()},$,'Column',$,$,{place},{s.body(column)},$,.COLUMN.)"))
    place = s.place(-WALL / 2, deep / 2, -SLAB, storey_place)
    s.products.append(s.add(f"IFCSLAB({s.guid()},$,'Slab',$,$,{place},{s.box(long + WALL, deep + WALL, SLAB)},$,.FLOOR.)"))
    storey = s.add(f"IFCBUILDINGSTOREY({s.guid()},$,'Storey \x05',$,$,{storey_place},$,$,.ELEMENT.,\x06)")
    s.add(f"IFCRELAGGREGATES({s.guid()},$,$,$,{storey},({','.join(s.spaces)}))")
    s.add(f"IFCRELCONTAINEDINSPATIALSTRUCTURE({s.guid()},$,$,$,({','.join(s.products)}),{storey})")
    s.add(f"IFCRELASSOCIATESMATERIAL({s.guid()},$,$,$,({','.join(s.walls)}),#33)")
    s.add(f"IFCRELAGGREGATES({s.guid()},$,$,$,#11,({storey}))")
    return s


def global_id(number):
    text = ""
    for _ in range(22):
        text = CODE[number % 64] + text
        number //= 64
    return text


def main():
    storeys, path = int(sys.argv[1]), sys.argv[2]
    s = make_storey()
    # One template of pieces between the numbers that change.
    import re
    text = "".join(f"\x01{number}\x02={line};\n" for number, line in s.lines)
    pieces = re.split("(\x01\\d+\x02|\x03|\x04|\x05|\x06)", text)
    with open(path, "w") as out:
        out.write(HEAD)
        first, guid = 100, 100
        for k in range(storeys):
            parts, z = [], k * (HIGH + SLAB)
            out.write(f"#{first}=IFCCARTESIANPOINT((0.,0.,{z}.));\n#{first + 1}=IFCAXIS2PLACEMENT3D(#{first},$,$);\n")
            for piece in pieces:
                if piece[:1] == "\x01":
                    parts.append(f"#{first + 2 + int(piece[1:-1])}")
                elif piece == "\x03":
                    guid += 1
                    parts.append(global_id(guid))
                elif piece == "\x04":
                    parts.append(f"#{first + 1}")
                elif piece == "\x05":
                    parts.append(str(k))
                elif piece == "\x06":
                    parts.append(f"{z}.")
                else:
                    parts.append(piece)
            out.write("".join(parts))
            first += s.count + 2
        out.write("ENDSEC;\nEND-ISO-10303-21;\n")


main()
