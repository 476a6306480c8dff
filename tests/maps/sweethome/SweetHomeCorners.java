// SweetHomeCorners.java - where Sweet Home 3D puts the pictures of a home: each textured triangle, with the places of its corners in
// its picture, and the solids of the home, in which nothing can be seen.
//
// Arguments: HOME. Lengths are metres, z up (the program: centimetres, y up). First a line a solid, SOLID z0 z1 a b x y x y ..: an
// upright prism over a polygon in plan, up to z1 + a x + b y. SOLID is
// - solid: a wall, along an arc up to the lower end of its top; a baseboard, with its wall; the slab under a room's floor, above the lowest level;
// - gap: where a solid may have a hole: a door or window, drawn out by a metre to both sides of its wall; all above a staircase's foot.
// Then a line a triangle, KIND IMAGE x y z u v x y z u v x y z u v, counter-clockwise as seen from the side that the program draws; u to
// the right and v down from the picture's upper left corner. KIND is wall, board (a baseboard), room, piece or ground; IMAGE width x height
// of the picture. Compile and run with the classpath of the program and Java 3D.
import com.eteks.sweethome3d.io.HomeFileRecorder;
import com.eteks.sweethome3d.j3d.Ground3D;
import com.eteks.sweethome3d.j3d.Object3DBranchFactory;
import com.eteks.sweethome3d.model.*;
import com.sun.j3d.utils.geometry.GeometryInfo;
import java.util.*;
import javax.media.j3d.*;
import javax.vecmath.*;

public class SweetHomeCorners {
  static void list(String kind, Node node, Transform3D outer) {
    Transform3D here = new Transform3D(outer);
    if (node instanceof TransformGroup) {
      Transform3D own = new Transform3D();
      ((TransformGroup) node).getTransform(own);
      here.mul(own);
    }
    if (node instanceof Group) {
      Enumeration<?> children = ((Group) node).getAllChildren();
      while (children.hasMoreElements()) list(kind, (Node) children.nextElement(), here);
    } else if (node instanceof Link) {
      list(kind, ((Link) node).getSharedGroup(), here);
    } else if (node instanceof Shape3D) {
      Shape3D shape = (Shape3D) node;
      Appearance look = shape.getAppearance();
      if (look == null || look.getTexture() == null) return;
      for (int i = 0; i < shape.numGeometries(); i++)
        if (shape.getGeometry(i) instanceof GeometryArray) list(kind, (GeometryArray) shape.getGeometry(i), look, here);
    }
  }

  static void list(String kind, GeometryArray geometry, Appearance look, Transform3D here) {
    TexCoordGeneration made = look.getTexCoordGeneration();
    boolean given = (geometry.getVertexFormat() & GeometryArray.TEXTURE_COORDINATE_2) != 0;
    if (made == null && !given) return;
    Vector4f s = new Vector4f(), t = new Vector4f();
    if (made != null) {
      made.getPlaneS(s);
      made.getPlaneT(t);
    }
    Transform3D turn = new Transform3D();
    if (look.getTextureAttributes() != null) look.getTextureAttributes().getTextureTransform(turn);
    GeometryInfo info = new GeometryInfo(geometry);
    info.convertToIndexedTriangles();
    Point3f[] points = info.getCoordinates();
    int[] at = info.getCoordinateIndices(), placeAt = made == null ? info.getTextureCoordinateIndices(0) : null;
    Object[] places = made == null ? (Object[]) info.getTextureCoordinates(0) : null;
    for (int i = 0; i + 2 < at.length; i += 3) {
      StringBuilder line = new StringBuilder(kind + " " + look.getTexture().getWidth() + "x" + look.getTexture().getHeight());
      for (int k = i; k < i + 3; k++) {
        Point3f p = new Point3f(points[at[k]]), uv;
        if (made != null)
          uv = new Point3f(p.x * s.x + p.y * s.y + p.z * s.z + s.w, p.x * t.x + p.y * t.y + p.z * t.z + t.w, 0);
        else
          uv = new Point3f(((TexCoord2f) places[placeAt[k]]).x, ((TexCoord2f) places[placeAt[k]]).y, 0);
        turn.transform(uv);
        here.transform(p);
        line.append(String.format(java.util.Locale.ROOT, " %.4f %.4f %.4f %.5f %.5f", p.x / 100, -p.z / 100, p.y / 100, uv.x, 1 - uv.y));
      }
      System.out.println(line);
    }
  }

  static void solid(String kind, float low, float high, float[][] points) { solid(kind, low, high, 0, 0, points); }

  static void solid(String kind, float low, float high, float a, float b, float[][] points) {
    StringBuilder line = new StringBuilder(
        String.format(java.util.Locale.ROOT, "%s %.4f %.4f %.6f %.6f", kind, low / 100, high / 100, a, -b));
    for (float[] p : points) line.append(String.format(java.util.Locale.ROOT, " %.4f %.4f", p[0] / 100, -p[1] / 100));
    System.out.println(line);
  }

  // The slab of a level, whose floor it carries; the lowest level has none.
  static float slab(Home home, Level level) {
    return level == null || level.getElevation() == home.getLevels().get(0).getElevation() ? 0 : level.getFloorThickness();
  }

  static float floor(Level level) { return level == null ? 0 : level.getElevation(); }

  static void listSolids(Home home, List<HomePieceOfFurniture> pieces) {
    for (Wall w : home.getWalls()) {
      float foot = floor(w.getLevel()), height = w.getHeight() == null ? home.getWallHeight() : w.getHeight(),
            end = w.getHeightAtEnd() == null ? height : w.getHeightAtEnd(), low = Math.min(height, end), a = 0, b = 0, c = foot + low;
      if (w.getArcExtent() == null) {
        float dx = w.getXEnd() - w.getXStart(), dy = w.getYEnd() - w.getYStart(), square = dx * dx + dy * dy;
        a = (end - height) * dx / square;
        b = (end - height) * dy / square;
        c = foot + height - a * w.getXStart() - b * w.getYStart();
      }
      solid("solid", foot - slab(home, w.getLevel()), c, a, b, w.getPoints());
      for (Baseboard board : new Baseboard[] {w.getLeftSideBaseboard(), w.getRightSideBaseboard()})
        if (board != null) solid("solid", foot, foot + Math.min(low, board.getHeight()), withBoard(w, board));
    }
    for (Room r : home.getRooms())
      if (slab(home, r.getLevel()) > 0)
        solid("solid", floor(r.getLevel()) - slab(home, r.getLevel()), floor(r.getLevel()), r.getPoints());
    for (HomePieceOfFurniture p : pieces) {
      if (p instanceof HomeDoorOrWindow) {
        HomePieceOfFurniture wide = p.clone();
        wide.setDepth(p.getDepth() + 200);
        float low = floor(p.getLevel()) + p.getElevation();
        solid("gap", low, low + p.getHeight(), wide.getPoints());
      } else if (p.getStaircaseCutOutShape() != null) {
        // It cuts no floor that it stands on.
        solid("gap", floor(p.getLevel()) + p.getElevation() + 1, 1e6f, p.getPoints());
      }
    }
  }

  // The outline of a wall with the baseboard on one of its sides.
  static float[][] withBoard(Wall wall, Baseboard board) {
    boolean left = board == wall.getLeftSideBaseboard();
    float[][] bare = wall.getPoints(), wide = wall.getPoints(true), out = bare.clone();
    // Points run along the left side first, then back along the right side.
    int half = bare.length / 2;
    for (int i = left ? 0 : half; i < (left ? half : bare.length); i++) out[i] = wide[i];
    return out;
  }

  static List<HomePieceOfFurniture> singlePieces(Home home) {
    List<HomePieceOfFurniture> all = new ArrayList<>();
    for (HomePieceOfFurniture p : home.getFurniture()) {
      if (p instanceof HomeFurnitureGroup) all.addAll(((HomeFurnitureGroup) p).getAllFurniture()); else all.add(p);
    }
    all.removeIf(p -> p instanceof HomeFurnitureGroup);
    return all;
  }

  public static void main(String[] a) throws Exception {
    Home home;
    try {
      home = new HomeFileRecorder(0, false, null, false, true).readHome(a[0]);
    } catch (DamagedHomeRecorderException e) {
      home = e.getDamagedHome();
    }
    for (Level level : home.getLevels()) level.setViewable(true);
    Object3DBranchFactory factory = new Object3DBranchFactory();
    Transform3D none = new Transform3D();
    List<HomePieceOfFurniture> pieces = singlePieces(home);
    listSolids(home, pieces);
    for (Wall w : home.getWalls()) {
      Group parts = (Group) factory.createObject3D(home, w, true);
      for (int i = 0; i < parts.numChildren(); i++) list(i / 2 == 1 ? "board" : "wall", parts.getChild(i), none);
    }
    for (Room r : home.getRooms()) list("room", (Node) factory.createObject3D(home, r, true), none);
    for (HomePieceOfFurniture p : pieces)
      if (p.getModel() != null) list("piece", (Node) factory.createObject3D(home, p, true), none);
    list("ground", new Ground3D(home, -5e6f, -5e6f, 1e7f, 1e7f, true), none);
    System.exit(0);
  }
}
