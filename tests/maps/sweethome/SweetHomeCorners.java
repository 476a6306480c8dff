// SweetHomeCorners.java - where Sweet Home 3D puts the pictures of a home: each textured triangle, with the places of its corners in its picture.
// Arguments: HOME. Prints a line a triangle: KIND IMAGE x y z u v x y z u v x y z u v, metres, z up (the program: centimetres,
// y up); u to the right and v down from the picture's upper left corner. KIND is wall, board (a baseboard), room, piece or ground; IMAGE width x height of the picture.
// Compile and run with the classpath of the program and Java 3D.
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
    for (Wall w : home.getWalls()) {
      Group parts = (Group) factory.createObject3D(home, w, true);
      for (int i = 0; i < parts.numChildren(); i++) list(i / 2 == 1 ? "board" : "wall", parts.getChild(i), none);
    }
    for (Room r : home.getRooms()) list("room", (Node) factory.createObject3D(home, r, true), none);
    for (HomePieceOfFurniture p : home.getFurniture()) {
      List<HomePieceOfFurniture> all = new ArrayList<>();
      if (p instanceof HomeFurnitureGroup) all.addAll(((HomeFurnitureGroup) p).getAllFurniture()); else all.add(p);
      for (HomePieceOfFurniture q : all)
        if (!(q instanceof HomeFurnitureGroup)) list("piece", (Node) factory.createObject3D(home, q, true), none);
    }
    list("ground", new Ground3D(home, -5e6f, -5e6f, 1e7f, 1e7f, true), none);
    System.exit(0);
  }
}
